//! Checks of a shape when a machine is created from it.

use crate::contact::edge::Edge;
use crate::contact::{ByDeflection, Deflection, FixedPieces, Nonlinearity, Piece, PieceChoice, Place};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::model::equations::Model;
use crate::model::shapes::compiled::Compiled;
use crate::model::shapes::shape::{Drives, Shape, Size};
use crate::numeric::spread::golden;
use std::cell::RefCell;
use std::f64::consts::TAU;

/// Largest difference of a wave after its period, as a share of the wave `[1]`.
const APART: f64 = 1e-6;

/// Number of angles at which a wave that seems not to repeat is compared once more.
const SPREAD: u32 = 256;

/// Evaluation by deflection that records the contacts of the laws that the algebra evaluates, and their
/// edges.
#[derive(Default)]
struct Witness {
    asked: RefCell<Vec<(usize, [f64; 2])>>,
}

impl PieceChoice<f64> for Witness {
    fn force<N: Nonlinearity>(&self, place: impl Into<Place>, law: &N, at: Deflection) -> f64 {
        let Place { contact, kinks } = place.into();
        let edges = [at.lower, at.upper];
        self.asked.borrow_mut().push((contact, edges));
        self.asked.borrow_mut().extend((kinks..kinks + law.kinks()).map(|kink| (kink, edges)));
        law.force(at)
    }
    fn touch(&self, i: usize, at: Deflection) -> f64 {
        self.asked.borrow_mut().push((i, [at.lower, at.upper]));
        at.touches()
    }
}

impl<G: Shape> Compiled<G> {
    /// Checks that the shape has degrees of freedom, that all waves are written, are numbers and repeat, and
    /// the contacts ([`check_contacts`](Machine::check_contacts)).
    pub(crate) fn check_shape(&self) -> Result<(), ParameterError> {
        let Size { dof, waves, .. } = self.size();
        if dof == 0 {
            return Err(ParameterError::TooFew {
                name: "degrees of freedom of the shape".into(),
                value: 0,
                min: 1,
            });
        }
        let Size { contacts, kinks, .. } = self.size();
        check::count("kinks of the shape", &[kinks], contacts)?;
        let turn = TAU / f64::from(self.repeats()?);
        // Three angles that no order favours, each one also a period of the waves later.
        let angles = [0.377, 0.377 + turn, 2.090, 2.090 + turn, 3.803, 3.803 + turn];
        let mut seen = [(); 6].map(|()| vec![f64::NAN; waves]);
        for (angle, u) in angles.into_iter().zip(&mut seen) {
            self.shape().waves(angle, Side::After, u);
        }
        for wave in 0..waves {
            let values = seen.each_ref().map(|u| u[wave]);
            if let Some(value) = values.into_iter().find(|value| value.is_nan()) {
                return Err(ParameterError::NotFinite { name: format!("wave {wave} of the shape"), value });
            }
            let size = values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            if values.chunks(2).any(|two| two[0] != two[1] && (two[0] - two[1]).abs() > APART * size)
                && !self.repeats_over_a_turn(wave, turn)
            {
                return Err(ParameterError::NotPeriodic {
                    name: format!("wave {wave} of the shape"),
                    period: turn,
                });
            }
        }
        self.check_contacts()
    }

    /// Whether a wave repeats after `turn`, from its values at angles spread over a turn: a pulse is almost 0
    /// at most of them, and its rounding errors there are no small share of it.
    fn repeats_over_a_turn(&self, wave: usize, turn: f64) -> bool {
        let (mut now, mut later) = (vec![f64::NAN; self.size().waves], vec![f64::NAN; self.size().waves]);
        let (mut size, mut apart) = (0.0f64, 0.0f64);
        for i in 1..=SPREAD {
            let angle = turn * golden(f64::from(i));
            self.shape().waves(angle, Side::After, &mut now);
            self.shape().waves(angle + turn, Side::After, &mut later);
            size = size.max(now[wave].abs()).max(later[wave].abs());
            if now[wave] != later[wave] {
                apart = apart.max((now[wave] - later[wave]).abs());
            }
        }
        apart <= APART * size
    }

    /// Checks, at rest at the angle 0, that the algebra evaluates laws of existing contacts only, and that
    /// [`Shape::contact`] returns a finite edge for each contact to whose law the algebra passes one.
    fn check_contacts(&self) -> Result<(), ParameterError> {
        let Size { dof, waves, contacts, .. } = self.size();
        let (mut u, rest, mut a) = (vec![0.0; self.drives()], vec![0.0; dof], vec![0.0; dof]);
        self.drive(0.0, Side::After, &mut u);
        let (u, witness) = (Drives::new(waves, &u), Witness::default());
        self.shape().accel(&witness, u, &rest, &rest, &mut a);
        for (i, edges) in witness.asked.into_inner() {
            if i >= contacts {
                return Err(ParameterError::NoSuchContact { contact: i, contacts });
            }
            let contact = self.shape().contact(&ByDeflection, i, u, &rest, &rest);
            if edges.iter().any(|x| x.is_finite())
                && contact.lower.is_infinite()
                && contact.upper.is_infinite()
            {
                return Err(ParameterError::NoEdges { contact: i });
            }
        }
        Ok(())
    }

    /// Checks that the accelerations at rest are finite: by deflection, with every contact on its lower
    /// flank and with every contact on its upper flank, in the gap if it does not have that flank.
    pub(crate) fn check_at_rest(&self) -> Result<(), ParameterError> {
        let Size { dof, waves, contacts, .. } = self.size();
        let (mut u, rest, mut a) = (vec![0.0; self.drives()], vec![0.0; dof], vec![f64::NAN; dof]);
        self.drive(0.0, Side::After, &mut u);
        let u = Drives::new(waves, &u);
        let number = |a: &[f64], how: &str| match a.iter().position(|a| !a.is_finite()) {
            Some(i) => Err(ParameterError::NotFinite {
                name: format!("acceleration {i} of the shape at rest{how}"),
                value: a[i],
            }),
            None => Ok(()),
        };
        self.shape().accel(&ByDeflection, u, &rest, &rest, &mut a);
        number(&a, "")?;
        for (edge, how) in [
            (Edge::Lower, ", contacts on their lower flanks"),
            (Edge::Upper, ", contacts on their upper flanks"),
        ] {
            let piece = |i: usize| {
                let contact = self.shape().contact(&ByDeflection, i, u, &rest, &rest);
                if edge.position(&contact).is_finite() { edge.flank() } else { Piece::Gap }
            };
            let pieces: Vec<Piece> = (0..contacts).map(piece).collect();
            a.fill(f64::NAN);
            self.shape().accel(&FixedPieces(&pieces), u, &rest, &rest, &mut a);
            number(&a, how)?;
        }
        Ok(())
    }
}
