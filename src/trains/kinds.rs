//! Kinds of modes of planetary sets, and where a mode stores its energy.

use crate::contact::Nonlinearity;
use crate::excitation::Side;
use crate::linear::{Mode, Modes};
use crate::trains::shape::elements::{Entry, PlanetPlace, PlanetSet};
use crate::trains::shape::train_shape::{Train, TrainShape};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// The kind of a mode of a planetary set with equally spaced planets.   Source: Lin and Parker 1999.
///
/// ```
/// use gear_dynamics::trains::ModeKind;
/// assert_eq!(ModeKind::of_harmonic(19, 3, 1), ModeKind::Translational); // 19 teeth, 3 planets
/// assert_eq!(ModeKind::of_harmonic(19, 3, 3), ModeKind::Rotational);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ModeKind {
    /// All planets move alike; central members turn and do not move sideways.
    Rotational,
    /// Central members move sideways and do not turn.
    Translational,
    /// Planets alone move.
    Planet,
    /// None of these: planets or spacing are unequal, or the mode belongs to another part of the train.
    Mixed,
}

impl ModeKind {
    /// The kind of modes that harmonic l of the mesh frequency excites in a set of N equally spaced planets
    /// round a sun of Z teeth: with k = l Z mod N, rotational modes for k = 0, translational ones for k = 1
    /// and N - 1, planet modes otherwise.   Source: Parker 2000, J. Sound Vib. 236, 561.
    pub fn of_harmonic(sun_teeth: u32, planets: u32, harmonic: u32) -> Self {
        let n = u64::from(planets.max(1));
        match u64::from(harmonic) * u64::from(sun_teeth) % n {
            0 => ModeKind::Rotational,
            k if k == 1 || k == n - 1 => ModeKind::Translational,
            _ => ModeKind::Planet,
        }
    }
}

/// Frequencies of one cluster differ by less than this share.
const CLUSTER: f64 = 1e-7;

/// Least projection on a symmetry at which a mode is of its kind.
const PURE: f64 = 1.0 - 1e-6;

impl<N: Nonlinearity> Train<N> {
    /// The kind of each mode, in the order of [`Modes::all`], by projection on the symmetries of the first
    /// planetary set. Modes whose frequencies agree to 1e-7 are separated by kind. A train without planets,
    /// with unequal spacing, or modes of another model, have [`ModeKind::Mixed`] alone.
    pub fn kinds(&self, modes: &Modes) -> Vec<ModeKind> {
        let list = modes.all();
        let own = list.iter().all(|mode| mode.shape().len() == self.shape().coordinates.len());
        let Some(set) = self.shape().sets.first().filter(|set| own && is_even(&set.planets)) else {
            return vec![ModeKind::Mixed; list.len()];
        };
        let shape = self.shape();
        let root: Vec<f64> = shape.masses.iter().map(|mass| mass.sqrt()).collect();
        let mut kinds = Vec::with_capacity(list.len());
        while kinds.len() < list.len() {
            let start = kinds.len();
            let near = |mode: &&Mode| {
                let gap = mode.frequency() - list[start].frequency();
                gap <= CLUSTER * mode.frequency()
            };
            let count = list[start..].iter().take_while(near).count();
            // An orthonormal basis of the cluster, in coordinates √m q.
            let motions: Vec<Vec<f64>> =
                list[start..start + count].iter().map(|mode| shape.in_inertial(mode.shape())).collect();
            let cluster = DMatrix::from_fn(root.len(), count, |i, k| root[i] * motions[k][i]);
            let basis = cluster.qr().q();
            let mut left = count;
            for kind in [ModeKind::Rotational, ModeKind::Translational, ModeKind::Planet] {
                let shares = shape.projected(set, &basis, kind).symmetric_eigenvalues();
                let pure = shares.iter().filter(|share| **share > PURE).count().min(left);
                kinds.extend(std::iter::repeat_n(kind, pure));
                left -= pure;
            }
            kinds.extend(std::iter::repeat_n(ModeKind::Mixed, left));
        }
        kinds
    }

    /// The shares of a mode's strain energy by element: springs and bearings by their names, meshes at the
    /// angle φ = `angle` of their waves. They add up to 1, except for a rigid motion, which has 0 everywhere.
    pub fn strain_energy(&self, mode: &Mode, angle: f64) -> Vec<(String, f64)> {
        let (shape, q) = (self.shape(), mode.shape());
        let of = |levers: &mut dyn Iterator<Item = Entry>| -> f64 {
            levers.filter_map(|entry| q.get(entry.at).map(|q| q * entry.by)).sum()
        };
        let pair =
            |at: [u32; 2], by: [f64; 2]| at.into_iter().zip(by).map(|(at, by)| Entry { at: at as usize, by });
        let mut energies = Vec::new();
        for spring in &shape.elements.springs {
            let x = of(&mut pair(spring.ends, spring.levers));
            energies.push((spring.name.clone(), spring.stiffness * x * x));
        }
        for spring in &shape.elements.row_springs {
            let x = of(&mut shape.elements.entries[spring.levers.clone()].iter().copied());
            energies.push((spring.name.clone(), spring.stiffness * x * x));
        }
        for (tooth, rest) in shape.teeth.iter().zip(&shape.rests) {
            let more = shape.elements.entries[rest.more_levers.clone()].iter().copied();
            let varying = shape.elements.varying[rest.varying.clone()].iter().map(|lever| {
                let g = shape.elements.jets[lever.wave].value(angle, Side::After);
                Entry { at: lever.at, by: lever.lever * g }
            });
            let x = of(&mut pair(tooth.at, tooth.levers).chain(more).chain(varying));
            let stiffness = shape.elements.single[tooth.stiffness as usize].value(angle, Side::After);
            energies.push((rest.channel.name.clone(), stiffness * x * x));
        }
        for journal in &shape.elements.journals {
            let squares = journal.levers.iter().map(|levers| {
                let x = of(&mut shape.elements.entries[levers.clone()].iter().copied());
                x * x
            });
            energies.push((journal.name.clone(), journal.stiffness * squares.sum::<f64>()));
        }
        let all: f64 = energies.iter().map(|energy| energy.1).sum();
        let rigid = mode.frequency() == 0.0 || all == 0.0;
        energies.iter_mut().for_each(|energy| energy.1 = if rigid { 0.0 } else { energy.1 / all });
        energies
    }
}

impl<N: Nonlinearity> TrainShape<N> {
    /// Bᵀ P B for the projection P on the modes of a kind, of vectors in coordinates √m q.
    fn projected(&self, set: &PlanetSet, basis: &DMatrix<f64>, kind: ModeKind) -> DMatrix<f64> {
        let mut image = DMatrix::zeros(basis.nrows(), basis.ncols());
        let centre_moves = set.central.iter().any(|&(_, sideways)| sideways);
        let (central, set) = (&set.central, &set.planets[..]);
        for k in 0..basis.ncols() {
            for &(row, sideways) in central {
                let own = if sideways { ModeKind::Translational } else { ModeKind::Rotational };
                if own == kind {
                    image[(row, k)] = basis[(row, k)];
                }
            }
            // Each planet in its radial and tangential directions.
            let local = |p: &PlanetPlace| -> [f64; 3] {
                let (sin, cos) = libm::sincos(p.angle);
                let [x, y] = p.centre.map_or([0.0; 2], |x| [basis[(x, k)], basis[(x + 1, k)]]);
                [p.at.map_or(0.0, |at| basis[(at, k)]), x * cos + y * sin, y * cos - x * sin]
            };
            let all: Vec<[f64; 3]> = set.iter().map(local).collect();
            let n = set.len() as f64;
            for p in set {
                // The part in harmonics ±h of the planets: Σ 2 cos h (ψ_p - ψ_o)/N, once for h = 0 and N/2.
                let harmonic = |h: f64| -> [f64; 3] {
                    let weight = if h == 0.0 || 2.0 * h == n { 1.0 } else { 2.0 };
                    let mut sums = [0.0; 3];
                    for (o, all) in set.iter().zip(&all) {
                        let cos = weight * libm::cos(h * (p.angle - o.angle)) / n;
                        sums.iter_mut().zip(all).for_each(|(sum, x)| *sum += cos * x);
                    }
                    sums
                };
                let own = all[set.iter().position(|o| o == p).unwrap_or(0)];
                let even = harmonic(0.0);
                let once = if set.len() > 1 && centre_moves { harmonic(1.0) } else { [0.0; 3] };
                let part: [f64; 3] = match kind {
                    ModeKind::Rotational => even,
                    ModeKind::Translational => once,
                    _ => std::array::from_fn(|i| own[i] - even[i] - once[i]),
                };
                let (sin, cos) = libm::sincos(p.angle);
                if let Some(at) = p.at {
                    image[(at, k)] = part[0];
                }
                if let Some(x) = p.centre {
                    image[(x, k)] = part[1] * cos - part[2] * sin;
                    image[(x + 1, k)] = part[1] * sin + part[2] * cos;
                }
            }
        }
        let product = basis.transpose() * image;
        (&product + product.transpose()) * 0.5
    }
}

/// Whether planets, in any order, are equally spaced.
fn is_even(planets: &[PlanetPlace]) -> bool {
    let mut angles: Vec<f64> = planets.iter().map(|planet| planet.angle.rem_euclid(TAU)).collect();
    angles.sort_by(f64::total_cmp);
    let step = TAU / planets.len() as f64;
    let even = angles.windows(2).all(|pair| (pair[1] - pair[0] - step).abs() < 1e-9);
    even && !planets.is_empty()
}
