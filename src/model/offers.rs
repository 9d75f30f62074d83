//! Optional parts of a model: fixed pieces, Jacobian, rigid stops. Only this module tests for them.

use crate::contact::piece::Piece;
use crate::excitation::side::Side;
use crate::model::equations::{Jacobian, Model};

/// Tests for the optional parts of a model. Each test calls the method of the part at time 0 with all
/// coordinates and velocities 0.
pub(crate) struct Offers<'m, M: ?Sized>(&'m M);

impl<'m, M: Model + ?Sized> Offers<'m, M> {
    pub(crate) fn of(model: &'m M) -> Self {
        Offers(model)
    }

    /// The drives at time 0, and zeros for the coordinates or the velocities.
    fn origin(&self) -> (Vec<f64>, Vec<f64>) {
        let mut u = vec![0.0; self.0.drives()];
        self.0.drive(0.0, Side::After, &mut u);
        (u, vec![0.0; self.0.dof()])
    }

    /// Whether the accelerations are available on fixed pieces. `true` for a model without contacts, which
    /// has no pieces.
    pub(crate) fn fixed_pieces(&self) -> bool {
        let pieces = vec![Piece::Gap; self.0.contacts()];
        if pieces.is_empty() {
            return true;
        }
        let (u, rest) = self.origin();
        self.0.accel_on_pieces(&pieces, &u, &rest, &rest, &mut rest.clone())
    }

    /// Whether the model provides its Jacobian.
    pub(crate) fn jacobian(&self) -> bool {
        let (u, rest) = self.origin();
        self.0.jacobian(None, &u, &rest, &rest, &mut Jacobian::new(rest.len()))
    }

    /// Whether the lower and the upper edge of every contact are rigid stops; empty if none is.
    pub(crate) fn rigid_edges(&self) -> Vec<[bool; 2]> {
        if self.0.contacts() == 0 {
            return Vec::new();
        }
        let (u, rest) = self.origin();
        let mut v = rest.clone();
        let mut rigid = |contact: usize| {
            [Piece::Lower, Piece::Upper].map(|on| self.0.impact(contact, on, &u, &rest, &mut v))
        };
        let all: Vec<[bool; 2]> = (0..self.0.contacts()).map(&mut rigid).collect();
        if all.iter().any(|rigid| *rigid != [false; 2]) { all } else { Vec::new() }
    }

    /// The first contact with a rigid stop. Methods that do not locate edges reject such a model.
    pub(crate) fn first_stop(&self) -> Option<usize> {
        self.rigid_edges().iter().position(|rigid| *rigid != [false; 2])
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::piece::Piece;
    use crate::model::equations::Model;
    use crate::model::offers::Offers;

    /// A ball over a rigid floor: contact 1 of two, on its lower edge.
    struct Ball;

    impl Model for Ball {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = -9.81;
        }
        fn contacts(&self) -> usize {
            2
        }
        fn impact(&self, contact: usize, on: Piece, _: &[f64], _: &[f64], v: &mut [f64]) -> bool {
            v[0] = -v[0];
            contact == 1 && on == Piece::Lower
        }
    }

    #[test]
    fn a_model_is_asked_for_its_optional_parts() {
        let offers = Offers::of(&Ball);
        assert!(!offers.fixed_pieces() && !offers.jacobian());
        assert_eq!(offers.rigid_edges(), [[false, false], [true, false]]);
        assert_eq!(offers.first_stop(), Some(1));
    }
}
