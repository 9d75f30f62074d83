//! The check of what a model declares.

use crate::check::inconsistency::Inconsistency;
use crate::check::point::CheckPoint;
use crate::contact::Piece;
use crate::model::Jacobian;

impl CheckPoint<'_> {
    /// Compares what [`Model::offers`] declares with what the methods do. A method that is not implemented
    /// writes NaN to all entries.
    pub(crate) fn offers(&self, findings: &mut Vec<Inconsistency>) {
        let (model, u, q, v) = (self.model, &self.u, &self.state.q, &self.state.v);
        let offers = model.offers();
        let mut compare = |method, declared: bool, implemented: bool| {
            if declared != implemented {
                findings.push(Inconsistency::Offers { method, declared });
            }
        };
        let is_written = |x: &[f64]| !x.iter().all(|x| x.is_nan());
        if model.contacts() > 0 {
            let mut a = vec![f64::NAN; model.dof()];
            model.accel_on_pieces(&self.pieces_at(q, v), u, q, v, &mut a);
            compare("accel_on_pieces", offers.pieces, is_written(&a));
        }
        let mut jacobian = Jacobian::new(model.dof());
        jacobian.q.fill(f64::NAN);
        jacobian.v.fill(f64::NAN);
        model.jacobian(None, u, q, v, &mut jacobian);
        compare(
            "jacobian",
            offers.jacobian,
            is_written(jacobian.q.as_slice()) || is_written(jacobian.v.as_slice()),
        );
        // Without a declared stop, an impact that changes no velocity stands for none.
        let has_stop = offers.first_stop().is_some();
        let moving: Vec<f64> = v.iter().map(|v| v + self.size[1]).collect();
        let changes = |(contact, on): (usize, Piece)| {
            let mut after = moving.clone();
            model.impact(contact, on, u, q, &mut after);
            is_written(&after) && (has_stop || after != moving)
        };
        let mut edges = (0..model.contacts()).flat_map(|c| [(c, Piece::Lower), (c, Piece::Upper)]);
        compare("impact", has_stop, edges.any(changes));
        if offers.stops.len() > model.contacts() {
            let (stops, contacts) = (offers.stops.len(), model.contacts());
            findings.push(Inconsistency::StopsOfNoContact { stops, contacts });
        }
    }
}
