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

    /// Contact `i` of the model, from its laws and the contacts at which teeth touch.
    #[inline(always)]
    pub(crate) fn contact<'n, S: Scalar, N: Nonlinearity + 'n>(
        &self,
        i: usize,
        law: impl FnOnce(usize) -> &'n N,
        touch: impl FnOnce(usize) -> Contact<S>,
    ) -> Contact<S> {
        let kink = i.checked_sub(self.touching).map(|kink| self.kinks[kink]);
        let contact = touch(kink.map_or(i, |[contact, _]| contact));
        let Some([of, k]) = kink else { return contact };
        Contact { deflection: law(of).kink(k, contact.deflection, contact.rate), ..contact }
    }
}
