//! Tip relief.

use crate::error::ParameterError;
use crate::numeric::search::bracket::Bracket;
use crate::teeth::error::{TeethError, check_spur, within};
use crate::teeth::geometry::pair::GearPair;
use crate::teeth::stiffness::piecewise::Piecewise;
use std::f64::consts::TAU;

/// Reliefs of the tips of both gears, as deviations along the line of contact.
///
/// The relief of the driven gear acts where pairs enter contact, that of the driving gear where they leave
/// it. With an amount C_a and a length L on the line of contact, a pair at the distance y from this end of
/// contact has lost C_a (1 - y/L)^p for y < L, p = 1 (linear) or 2 (parabolic).
///
/// ```
/// use gear_dynamics::{excitation::Excitation, teeth::{InvoluteGear, GearPair, TipRelief}};
/// let gear = InvoluteGear::external(40, 0.003)?;
/// let pair = GearPair::new(&gear, &gear)?;
/// let long = pair.length_of_contact() - pair.base_pitch(); // relief up to single contact
/// let short = TipRelief::new([20e-6; 2], [long; 2])?.unloaded_error(&pair)?;
/// assert!(short.value(0.1).abs() < 6e-6 && short.value(5.0).abs() < 1e-18);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipRelief {
    amounts: [f64; 2],
    lengths: [f64; 2],
    parabolic: bool,
}

impl TipRelief {
    /// Linear reliefs of the tips of gear 0 and gear 1: amounts C_a, lengths L on the line of contact `[m]`.
    ///
    /// # Errors
    /// An amount outside 0 .. 0.01 m; a length outside 1e-9 .. 1 m.
    pub fn new(amounts: [f64; 2], lengths: [f64; 2]) -> Result<Self, ParameterError> {
        for i in 0..2 {
            within(&format!("amount of relief of gear {i}"), amounts[i], [0.0, 0.01], "[0, 0.01] m")?;
            within(&format!("length of relief of gear {i}"), lengths[i], [1e-9, 1.0], "[1e-9, 1] m")?;
        }
        Ok(TipRelief { amounts, lengths, parabolic: false })
    }
    /// The same reliefs with a parabolic course, tangent to the involute.
    pub fn parabolic(self) -> Self {
        TipRelief { parabolic: true, ..self }
    }

    /// What a pair has lost at a place `s` on its path of contact `[m]`, s in base pitches from the start of
    /// contact, 0 .. ε_α.
    ///
    /// # Errors
    /// A place outside 0 .. ε_α.
    pub fn at(&self, pair: &GearPair, s: f64) -> Result<f64, ParameterError> {
        within("place on the path of contact", s, [0.0, pair.contact_ratio()], "[0, contact ratio]")?;
        Ok(self.lost(pair, s))
    }
    fn lost(&self, pair: &GearPair, s: f64) -> f64 {
        let along = [pair.contact_ratio() - s, s];
        let loss = |i: usize| {
            let share = (1.0 - along[i] * pair.base_pitch() / self.lengths[i]).max(0.0);
            self.amounts[i] * if self.parabolic { share * share } else { share }
        };
        loss(0) + loss(1)
    }

    /// The transmission error without load over the mesh cycle `[m]`: the least that one of the pairs in
    /// contact has lost, e(φ) = min_i δ(s_i) >= 0, with the sign of [`Mesh`](crate::Mesh): the driving gear
    /// turns ahead until a pair touches. Its kinks are edges. φ = 0: a pair enters contact.
    ///
    /// It is 0 if the reliefs leave one pair on its involute at every angle (short relief). Under load the
    /// pairs deflect, and the reliefs also delay the contact of relieved pairs, which this wave does not
    /// contain.
    ///
    /// # Errors
    /// A relief longer than the line of contact; [`TeethError::Helical`] for helical teeth, of which another
    /// section may touch first.
    pub fn unloaded_error(&self, pair: &GearPair) -> Result<Piecewise, TeethError> {
        check_spur(pair.gears()[0].helix_angle())?;
        let (ratio, pitch) = (pair.contact_ratio(), pair.base_pitch());
        for (i, length) in self.lengths.iter().enumerate() {
            let name = format!("length of relief of gear {i}");
            within(&name, *length, [0.0, pair.length_of_contact()], "[0, length of contact]")?;
        }
        let [end, start] = self.lengths.map(|length| length / pitch);
        let mut kinks: Vec<f64> = [0.0, ratio, start, ratio - end].iter().map(|s| s - s.floor()).collect();
        kinks.sort_by(f64::total_cmp);
        let crossings: Vec<f64> = (0..kinks.len())
            .flat_map(|i| {
                let to = kinks.get(i + 1).copied().unwrap_or(1.0);
                self.crossings(pair, kinks[i], to)
            })
            .collect();
        kinks.extend(crossings);
        kinks.sort_by(f64::total_cmp);
        let edges: Vec<f64> = kinks.iter().map(|s| s * TAU).filter(|edge| *edge < TAU).collect();
        Piecewise::fit(&edges, 1e-12, |middle, phi| {
            // The pair that has lost least does not change inside a piece.
            let first = self.least(pair, middle / TAU);
            Ok(self.lost(pair, phi / TAU + first))
        })
    }

    /// The pair that has lost least at a place of the latest pair, as a number of pitches ahead of it.
    fn least(&self, pair: &GearPair, s: f64) -> f64 {
        let lost = |k: &f64| self.lost(pair, s + k);
        pairs(pair, s).min_by(|a, b| lost(a).total_cmp(&lost(b))).unwrap_or(0.0)
    }

    /// Places between two kinks at which two pairs have lost the same.
    fn crossings(&self, pair: &GearPair, from: f64, to: f64) -> Vec<f64> {
        let middle = 0.5 * (from + to);
        let all: Vec<f64> = pairs(pair, middle).collect();
        let mut found = Vec::new();
        for (i, a) in all.iter().enumerate() {
            for b in &all[i + 1..] {
                let ahead = |s: f64| self.lost(pair, s + a) - self.lost(pair, s + b);
                if ahead(from) * ahead(to) < 0.0 {
                    let same = |s: f64| (ahead(s) > 0.0) == (ahead(from) > 0.0);
                    found.push(Bracket { lo: from, hi: to }.bisect(0.0, same).lo);
                }
            }
        }
        found
    }
}

/// Numbers of pitches by which the pairs in contact are ahead of the latest one at its place s.
fn pairs(pair: &GearPair, s: f64) -> impl Iterator<Item = f64> {
    let last = pair.contact_ratio() - s;
    (0..).map(f64::from).take_while(move |k| *k <= last)
}
