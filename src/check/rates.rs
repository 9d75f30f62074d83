//! Comparison of the rates of contacts with differences of their deflections and edges.

use crate::check::inconsistency::Inconsistency;
use crate::check::point::CheckPoint;
use crate::check::tolerances::{ROUGH, ROUNDING};
use crate::contact::Contact;
use crate::excitation::Side;
use crate::model::State;
use crate::numeric::spread::golden;
use crate::ode::probe::Probe;

/// Number of steps of the differences, each a tenth of the one before.
const DIFFERENCES: i32 = 10;

/// Number of further phases of each span at which the rates are compared.
const PHASES: u32 = 4;

/// Spans of time in the place of a period that is not known.
const SPANS: [f64; 4] = [1.0, 1e-3, 1e3, 1e-6];

/// A difference quotient and a bound of its rounding.
#[derive(Clone, Copy)]
struct Quotient {
    value: f64,
    rounding: f64,
}

impl Quotient {
    /// Whether a rate that the model gives equals this difference quotient, up to [`ROUGH`] of the larger of
    /// the two plus the rounding of the quotient.
    fn agrees(&self, given: f64) -> bool {
        (given - self.value).abs() <= ROUGH * given.abs().max(self.value.abs()) + self.rounding
    }

    /// Whether rounding is at most 1 % of the larger of the quotient and the given rate.
    fn tells(&self, given: f64) -> bool {
        self.rounding <= 1e-2 * given.abs().max(self.value.abs())
    }
}

/// The quotient that contradicts a given rate: two successive steps agree on it within 1 %, and no accurate
/// step agrees with the given rate. `None` if there is no contradiction.
fn contradiction(given: f64, quotients: &[Quotient]) -> Option<f64> {
    let telling = || quotients.iter().filter(|x| x.tells(given));
    if telling().any(|x| x.agrees(given)) {
        return None;
    }
    let settled = quotients.windows(2).find(|pair| {
        let size = given.abs().max(pair[0].value.abs()).max(pair[1].value.abs());
        pair.iter().all(|x| x.tells(given)) && (pair[0].value - pair[1].value).abs() <= 1e-2 * size
    });
    settled.map(|pair| pair[0].value)
}

impl Inconsistency {
    /// The contact whose rate is wrong, and whether it is that of its deflection.
    fn rate_of(&self) -> Option<(usize, bool)> {
        match self {
            Inconsistency::ContactRate { contact, .. } => Some((*contact, true)),
            Inconsistency::EdgeRate { contact, .. } => Some((*contact, false)),
            _ => None,
        }
    }
}

impl CheckPoint<'_> {
    /// Compares the rates of deflections and edges with central differences in time along the motion q' =
    /// v, v' = a, at the typical instant and at further phases of the period: at t = 0 the rate of a cosine
    /// is 0. It also compares ∂(rate)/∂v with ∂(deflection)/∂q, which is possible at rest as well.
    pub(crate) fn rates(&self, period: Option<f64>, findings: &mut Vec<Inconsistency>) {
        let mut wrong = self.along_the_motion(period);
        let spans = period.map_or(SPANS.to_vec(), |period| vec![period]);
        for (span, i) in spans.into_iter().flat_map(|span| (1..=PHASES).map(move |i| (span, i))) {
            let later = self.at(self.state.t + golden(f64::from(i)) * span).along_the_motion(period);
            for finding in later {
                if wrong.iter().all(|known| known.rate_of() != finding.rate_of()) {
                    wrong.push(finding);
                }
            }
        }
        let State { q, v, t } = &self.state;
        let mut probe = Probe::new(self.model);
        let here: Vec<Contact> = probe.read_contacts(*t, Side::After, q, v).to_vec();
        let touching = self.model.offers().touching(here.len());
        for (contact, c) in here[..touching].iter().enumerate() {
            if wrong.iter().all(|known| known.rate_of() != Some((contact, true))) {
                wrong.extend(self.rate_by_velocity(contact, c));
            }
        }
        findings.extend(wrong);
    }

    /// Compares the rates with differences along the motion, at the instant of this point.
    fn along_the_motion(&self, period: Option<f64>) -> Vec<Inconsistency> {
        let mut findings = Vec::new();
        let mut probe = Probe::new(self.model);
        let (t, q, v) = (self.state.t, &self.state.q, &self.state.v);
        let here: Vec<Contact> = probe.read_contacts(t, Side::After, q, v).to_vec();
        if here.is_empty() {
            return findings;
        }
        let a = self.accel(q, v);
        let still = v.iter().all(|v| *v == 0.0);
        let longest =
            1e-3 * period.unwrap_or(if still { 1.0 } else { (self.size[0] / self.size[1]).min(1.0) });
        let mut moved = |h: f64| {
            let along = |x: &[f64], rate: &[f64]| -> Vec<f64> {
                x.iter().zip(rate).map(|(x, rate)| x + h * rate).collect()
            };
            probe.read_contacts(t + h, Side::After, &along(q, v), &along(v, &a)).to_vec()
        };
        let steps: Vec<f64> =
            (0..DIFFERENCES).map(|i| longest * 0.1f64.powi(i)).filter(|h| t + h > t).collect();
        let sides: Vec<_> = steps.iter().map(|h| (((t + h) - (t - h)), moved(*h), moved(-*h))).collect();
        let touching = self.model.offers().touching(here.len());
        for (contact, c) in here[..touching].iter().enumerate() {
            let wrong = |given: f64, terms: f64, of: &dyn Fn(&Contact) -> f64| {
                let quotient = |(twice, plus, minus): &(f64, Vec<Contact>, Vec<Contact>)| Quotient {
                    value: (of(&plus[contact]) - of(&minus[contact])) / twice,
                    rounding: ROUNDING * (terms + given.abs() * t.abs()) / twice,
                };
                if !of(c).is_finite() {
                    return None;
                }
                contradiction(given, &sides.iter().map(quotient).collect::<Vec<_>>())
            };
            if let Some(differences) = wrong(c.rate, self.reach[contact], &|c| c.deflection) {
                findings.push(Inconsistency::ContactRate { contact, given: c.rate, differences });
            }
            for (given, differences) in [
                (c.lower_rate, wrong(c.lower_rate, c.lower.abs(), &|c| c.lower)),
                (c.upper_rate, wrong(c.upper_rate, c.upper.abs(), &|c| c.upper)),
            ] {
                findings.extend(differences.map(|differences| Inconsistency::EdgeRate {
                    contact,
                    given,
                    differences,
                }));
            }
        }
        findings
    }

    /// Checks ∂(rate)/∂v = ∂(deflection)/∂q, for a deflection that does not depend on velocities.
    fn rate_by_velocity(&self, contact: usize, c: &Contact) -> Option<Inconsistency> {
        let (q, v) = (&self.state.q, &self.state.v);
        for j in 0..q.len() {
            let mut faster = v.clone();
            faster[j] += self.size[1];
            let gained = faster[j] - v[j];
            let fast = self.contacts(q, &faster)[contact];
            if fast.deflection != c.deflection {
                return None;
            }
            let given = (fast.rate - c.rate) / gained;
            let quotients: Vec<Quotient> = (2..DIFFERENCES)
                .map(|i| {
                    let h = self.size[0] * 0.1f64.powi(i);
                    let (mut plus, mut minus) = (q.clone(), q.clone());
                    (plus[j], minus[j]) = (q[j] + h, q[j] - h);
                    let twice = plus[j] - minus[j];
                    let [a, b] = [plus, minus].map(|q| self.contacts(&q, v)[contact].deflection);
                    let rounding = ROUNDING * (self.reach[contact] / twice + c.rate.abs() / gained);
                    Quotient { value: (a - b) / twice, rounding }
                })
                .collect();
            if let Some(slope) = contradiction(given, &quotients) {
                return Some(Inconsistency::ContactRate {
                    contact,
                    given: fast.rate,
                    differences: c.rate + slope * gained,
                });
            }
        }
        None
    }
}
