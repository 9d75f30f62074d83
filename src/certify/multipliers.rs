//! Enclosures of the Floquet multipliers.

use crate::certify::square::Square;
use crate::interval::number::Interval;
use crate::periodic::Stability;
use crate::scalar::Scalar;
use nalgebra::{Complex, DMatrix, DVector};

/// A disc in the complex plane that contains a Floquet multiplier.
///
/// ```
/// use gear_dynamics::certify::Disc;
/// let disc = Disc { re: 0.3, im: 0.4, radius: 1e-9 };
/// assert!(disc.least_modulus() < 0.5 && 0.5 < disc.largest_modulus());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Disc {
    /// Real part of the centre.
    pub re: f64,
    /// Imaginary part of the centre.
    pub im: f64,
    /// Radius.
    pub radius: f64,
}

impl Disc {
    fn modulus(&self) -> Interval {
        let square = Interval::from(self.re).square() + Interval::from(self.im).square();
        square.max(Interval::ZERO).sqrt() + Interval::symmetric(self.radius)
    }
    /// Upper bound of |μ|.
    pub fn largest_modulus(&self) -> f64 {
        self.modulus().high()
    }
    /// Lower bound of |μ|, at least 0.
    pub fn least_modulus(&self) -> f64 {
        self.modulus().low().max(0.0)
    }
    /// Whether the other disc lies in this one.
    pub fn contains(&self, other: &Disc) -> bool {
        let reach = self.apart(other) + Interval::from(other.radius);
        self == other || reach.high() <= self.radius
    }
    fn meets(&self, other: &Disc) -> bool {
        self.apart(other).low() <= (self.radius + other.radius).next_up()
    }
    /// The distance of the centres.
    fn apart(&self, other: &Disc) -> Interval {
        let [re, im] = [(self.re, other.re), (self.im, other.im)]
            .map(|(own, other)| (Interval::from(own) - Interval::from(other)).square());
        (re + im).max(Interval::ZERO).sqrt()
    }
}

/// What the discs say of the stability. A group of discs that meet contains as many multipliers as discs.
pub(crate) fn stability(discs: &[Disc]) -> Stability {
    if discs.iter().all(|disc| disc.largest_modulus() < 1.0) {
        return Stability::Stable;
    }
    let outside = |disc: &Disc| disc.least_modulus() > 1.0;
    // A group that lies outside of the unit circle as a whole.
    let unstable = (0..discs.len()).any(|i| {
        let mut group = vec![i];
        let mut next = 0;
        while next < group.len() {
            let more: Vec<usize> = (0..discs.len())
                .filter(|k| !group.contains(k) && discs[group[next]].meets(&discs[*k]))
                .collect();
            group.extend(more);
            next += 1;
        }
        group.iter().all(|k| outside(&discs[*k]))
    });
    if unstable { Stability::Unstable } else { Stability::Undecided }
}

/// Enclosures of all multipliers of the product of the slopes; `None` if they cannot be separated.
///
/// Frames V_j of the approximate Floquet solutions make every V_(j+1)⁻¹ Φ_j V_j almost diagonal, so that
/// their product does not grow by wrapping. Discs of Gershgorin around the diagonal of the product contain
/// the multipliers. `turn`: the product in plain numbers.
pub(crate) fn discs(slopes: &[Square], turn: &DMatrix<f64>) -> Option<Vec<Disc>> {
    let (mut frame, pairs) = first_frame(turn)?;
    let start = frame.clone();
    let d = turn.nrows();
    let mut product = Square::identity(d);
    for slope in slopes {
        let mut next = slope.middle() * &frame;
        scale_columns(&mut next, &pairs);
        let inverse = inverse(&next)?;
        product = inverse.times(&slope.times(&exact(&frame))).times(&product);
        frame = next;
    }
    // V_0⁻¹ (V_N P) is similar to the derivative over one turn.
    let similar = inverse(&start)?.times(&exact(&frame)).times(&product);
    gershgorin(&similar, &pairs)
}

/// Squarings of the derivative over a turn.
const SQUARINGS: u32 = 12;

/// One disc around 0 for all multipliers, if it lies inside the unit circle: |μ| <= |M^k|^(1/k), with
/// orthogonal frames in place of those of the solutions. `None` otherwise.
pub(crate) fn within(slopes: &[Square]) -> Option<Vec<Disc>> {
    let d = slopes.first()?.size;
    let mut frame = DMatrix::identity(d, d);
    let mut product = Square::identity(d);
    for slope in slopes {
        let next = (slope.middle() * &frame).qr().q();
        product = inverse(&next)?.times(&slope.times(&exact(&frame))).times(&product);
        frame = next;
    }
    let mut power = exact(&frame).times(&product);
    for squared in 0..SQUARINGS {
        let rows = (0..d).map(|i| {
            (0..d).fold(Interval::ZERO, |sum, j| sum + Interval::from(power.at(i, j).magnitude())).high()
        });
        let norm = rows.fold(0.0, f64::max);
        if norm < 1.0 {
            let root = (0..squared).fold(Interval::from(norm), |norm, _| norm.sqrt());
            return Some(vec![Disc { re: 0.0, im: 0.0, radius: root.high() }; d]);
        }
        power = power.times(&power);
    }
    None
}

/// Columns of real eigenvectors and of real and imaginary parts of complex ones; whether a column begins such
/// a pair.
fn first_frame(turn: &DMatrix<f64>) -> Option<(DMatrix<f64>, Vec<bool>)> {
    let d = turn.nrows();
    let values = turn.clone().schur().complex_eigenvalues();
    let (mut columns, mut pairs) = (Vec::<DVector<f64>>::new(), Vec::new());
    for value in values.iter().filter(|value| value.im >= 0.0) {
        // The eigenvector by inverse iteration from a point beside the eigenvalue.
        let size = turn.norm().max(f64::MIN_POSITIVE);
        let shifted = DMatrix::from_fn(d, d, |i, j| {
            let diagonal =
                if i == j { *value + Complex::new(1e-10 * size, 0.0) } else { Complex::new(0.0, 0.0) };
            Complex::new(turn[(i, j)], 0.0) - diagonal
        });
        let lu = shifted.lu();
        let mut vector = DVector::from_fn(d, |i, _| Complex::new(1.0, 0.3 * (1.0 + i as f64)));
        for _ in 0..4 {
            vector = lu.solve(&vector)?;
            let size = vector.norm();
            vector /= Complex::new(size, 0.0);
        }
        // A real vector, or one whose largest entry is real.
        let largest = vector
            .iter()
            .fold(Complex::new(0.0, 0.0), |m: Complex<f64>, x| if x.norm() > m.norm() { *x } else { m });
        vector /= largest;
        pairs.push(value.im > 0.0);
        columns.push(vector.map(|x| x.re));
        if value.im > 0.0 {
            pairs.push(false);
            columns.push(vector.map(|x| x.im));
        }
    }
    (columns.len() == d).then(|| (DMatrix::from_columns(&columns), pairs))
}

/// Scales the columns to the size 1, both of a pair by one factor.
fn scale_columns(frame: &mut DMatrix<f64>, pairs: &[bool]) {
    let mut j = 0;
    while j < pairs.len() {
        let width = if pairs[j] { 2 } else { 1 };
        let mut columns = frame.columns_mut(j, width);
        let size = columns.norm();
        columns /= size;
        j += width;
    }
}

fn exact(matrix: &DMatrix<f64>) -> Square {
    Square::from_fn(matrix.nrows(), |i, j| Interval::from(matrix[(i, j)]))
}

/// The inverse of a matrix: an approximate one W, with |V⁻¹ - W| bounded by ε/(1 - ε) times the largest entry
/// of the columns of W, ε the norm of 1 - W V.
fn inverse(matrix: &DMatrix<f64>) -> Option<Square> {
    let approximate = exact(&matrix.clone().try_inverse()?);
    let d = matrix.nrows();
    let product = approximate.times(&exact(matrix));
    let rows = (0..d).map(|i| {
        (0..d).fold(Interval::ZERO, |sum, j| {
            let unit = if i == j { Interval::ONE } else { Interval::ZERO };
            sum + Interval::from((unit - product.at(i, j)).magnitude())
        })
    });
    let error = rows.fold(0.0, |most: f64, row| most.max(row.high()));
    if error.is_nan() || error >= 0.5 {
        return None;
    }
    let share = Interval::from(error) / (Interval::ONE - Interval::from(error));
    Some(Square::from_fn(d, |i, j| {
        let largest = (0..d).fold(0.0, |most: f64, k| most.max(approximate.at(k, j).magnitude()));
        approximate.at(i, j) + Interval::symmetric((share * largest).high())
    }))
}

/// Discs around the diagonal of a matrix that is almost diagonal, up to pairs [[a, b], [-b, a]]: the block
/// theorem of Gershgorin in the 2-norm, in which such a pair is normal, with sums of magnitudes as bounds of
/// the other blocks.   Source: Feingold & Varga, Pacific J. Math. 12, 1241 (1962).
fn gershgorin(matrix: &Square, pairs: &[bool]) -> Option<Vec<Disc>> {
    let d = matrix.size;
    let mut discs = Vec::with_capacity(d);
    let mut i = 0;
    while i < d {
        let width = if pairs[i] { 2 } else { 1 };
        let others = (i..i + width).flat_map(|row| (0..d).map(move |column| (row, column)));
        let outside = others
            .filter(|(_, column)| !(i..i + width).contains(column))
            .fold(Interval::ZERO, |sum, (row, column)| {
                sum + Interval::from(matrix.at(row, column).magnitude())
            });
        if width == 1 {
            let own = matrix.at(i, i);
            let radius = (Interval::from(0.5 * own.width()) + outside).high();
            discs.push(Disc { re: own.middle(), im: 0.0, radius: radius + f64::EPSILON * own.magnitude() });
        } else {
            let [a, b, c, e] =
                [(i, i), (i, i + 1), (i + 1, i), (i + 1, i + 1)].map(|(row, column)| matrix.at(row, column));
            let (re, im) = ((a + e) * 0.5, (b - c) * 0.5);
            let rest =
                Interval::from(((a - e) * 0.5).magnitude()) + Interval::from(((b + c) * 0.5).magnitude());
            let middle = Interval::from(0.5 * re.width()) + Interval::from(0.5 * im.width());
            let rounding = Interval::from(f64::EPSILON) * Interval::from(re.magnitude() + im.magnitude());
            let radius = (rest + middle + outside + rounding).high();
            discs.push(Disc { re: re.middle(), im: im.middle(), radius });
            discs.push(Disc { re: re.middle(), im: -im.middle(), radius });
        }
        i += width;
    }
    discs.iter().all(|disc| disc.radius.is_finite()).then_some(discs)
}
