//! Extremes of an orbit in the order of their phases, for comparisons of many extremes.

use crate::branches::orbits::contact_trace::{Extremum, NEAR};

/// The extremes of one orbit: a list for each edge and kind of each contact, in the order of their phases.
pub(crate) struct SortedExtremes<'t> {
    lists: Vec<Vec<&'t Extremum>>,
}

impl<'t> SortedExtremes<'t> {
    pub(crate) fn of(extremes: &'t [Extremum]) -> Self {
        let kinds = extremes.iter().map(|e| kind(e) + 1).max().unwrap_or(0);
        let mut lists: Vec<Vec<&Extremum>> = vec![Vec::new(); kinds];
        extremes.iter().for_each(|e| lists[kind(e)].push(e));
        lists.iter_mut().for_each(|list| list.sort_by(|a, b| a.phase.total_cmp(&b.phase)));
        SortedExtremes { lists }
    }

    /// The extremum like `near` with the nearest phase: the last one before it or the first one after it on
    /// the circle of phases.
    pub(crate) fn nearest(&self, near: &Extremum) -> Option<&'t Extremum> {
        let list = self.lists.get(kind(near))?;
        let after = list.partition_point(|e| e.phase < near.phase);
        let before = after.checked_sub(1).map_or(list.last(), |before| list.get(before));
        let around = [before, list.get(after).or(list.first())].into_iter().flatten().copied();
        around.min_by(|a, b| a.apart(near.phase).total_cmp(&b.apart(near.phase)))
    }

    /// The extremum of this orbit that corresponds to the extremum `of` of a neighbouring orbit. Two extremes
    /// correspond if each is the nearest one to the other. `None`: no extremum corresponds to `of`.
    pub(crate) fn same(&self, of: &Extremum, in_orbit: &SortedExtremes<'_>) -> Option<&'t Extremum> {
        let here = self.nearest(of).filter(|here| here.apart(of.phase) < NEAR)?;
        in_orbit.nearest(here).is_some_and(|back| back.phase == of.phase).then_some(here)
    }
}

/// Place of the list of an extremum.
fn kind(e: &Extremum) -> usize {
    4 * e.contact + 2 * e.edge as usize + usize::from(e.maximum)
}

#[cfg(test)]
mod tests {
    use crate::branches::orbits::contact_trace::{ContactTrace, Extremum};
    use crate::branches::orbits::sorted_extremes::SortedExtremes;
    use crate::contact::edge::Edge;
    use crate::numeric::spread::weyl;

    /// The nearest extremum equals that of a search through all of them.
    #[test]
    fn the_nearest_of_many() {
        let extremes: Vec<Extremum> = (0..300)
            .map(|k| Extremum {
                contact: k % 3,
                edge: Edge::BOTH[k / 3 % 2],
                maximum: k / 6 % 2 == 0,
                phase: weyl(k, 0),
                distance: weyl(k, 1) - 0.5,
            })
            .collect();
        let sorted = SortedExtremes::of(&extremes);
        let trace = ContactTrace { extremes: extremes.clone(), ..ContactTrace::new(3) };
        for (k, extremum) in extremes.iter().enumerate() {
            let near = Extremum { phase: weyl(k, 2), ..*extremum };
            assert_eq!(sorted.nearest(&near), trace.nearest(&near));
        }
        assert_eq!(sorted.nearest(&Extremum { contact: 3, ..extremes[0] }), None);
        assert_eq!(SortedExtremes::of(&[]).nearest(&extremes[0]), None);
    }
}
