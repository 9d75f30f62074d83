//! The contacts of several laws in one model.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::piece_choice::Place;
use crate::contact::tooth::Contact;
use crate::scalar::Scalar;

/// The places of the laws of a model: the contacts at which teeth touch come first, in the order of the laws,
/// the inner kinks of all laws last.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LawPlaces {
    touching: usize,
    /// The contact of the first inner kink of each law.
    first_kinks: Vec<usize>,
    /// For each inner kink, its law and its number there.
    kinks: Vec<[usize; 2]>,
}

impl LawPlaces {
    /// The places of `laws` in a model in which teeth touch at the first `touching` contacts.
    pub(crate) fn of<'n, N: Nonlinearity + 'n>(laws: impl Iterator<Item = &'n N>, touching: usize) -> Self {
        let (mut first_kinks, mut kinks) = (Vec::new(), Vec::new());
        for (contact, law) in laws.enumerate() {
            first_kinks.push(touching + kinks.len());
            kinks.extend((0..law.kinks()).map(|k| [contact, k]));
        }
        LawPlaces { touching, first_kinks, kinks }
    }

    /// The place of law `i`. A law without inner kinks reads no list.
    #[inline(always)]
    pub(crate) fn of_law(&self, i: usize) -> Place {
        Place { contact: i, kinks: self.first_kinks.get(i).copied().unwrap_or(self.touching) }
    }
    /// Number of inner kinks.
    #[inline(always)]
    pub(crate) fn kinks(&self) -> usize {
        self.kinks.len()
    }

    /// Contact `i` of the model is a pair of teeth or an inner kink. Returns the number of the pair of teeth
    /// and, for an inner kink, the number of its law and the number of the kink in this law.
    #[inline(always)]
    pub(crate) fn place(&self, i: usize) -> (usize, Option<[usize; 2]>) {
        match i.checked_sub(self.touching) {
            None => (i, None),
            Some(kink) => (self.kinks[kink][0], Some(self.kinks[kink])),
        }
    }
    /// The contact of an inner kink, from the contact at which its teeth touch.
    pub(crate) fn kink<S: Scalar>(law: &impl Nonlinearity, k: usize, touch: Contact<S>) -> Contact<S> {
        Contact { deflection: law.kink(k, touch.deflection, touch.rate), ..touch }
    }
}
