//! Crossings: the instants at which contacts change their piece along a sampled orbit.

use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::periodic::balance::crossings::stencil::{Polynomial, Stencil};
use crate::periodic::balance::series::grid::Grid;

/// One change of piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OrbitCrossing {
    pub(crate) contact: usize,
    pub(crate) from: Piece,
    pub(crate) to: Piece,
    /// Between samples `cell` and `cell + 1`.
    pub(crate) cell: usize,
    /// Position in the cell, -1/2 .. 1/2.
    pub(crate) phi: f64,
    /// d(deflection - edge)/dφ.
    pub(crate) slope: f64,
}

impl OrbitCrossing {
    /// Time of the change; `step` is the time between two samples.
    pub(crate) fn time(&self, step: f64) -> f64 {
        (self.cell as f64 + 0.5 + self.phi) * step
    }
}

/// Distances of every contact from its edges, and the crossings between its pieces.
pub(crate) struct Crossings {
    /// For each edge and contact: deflection minus edge at every sample, and its change over a sample.
    distances: [Vec<Vec<[f64; 2]>>; 2],
    contacts: Vec<Contact>,
    list: Vec<OrbitCrossing>,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl Crossings {
    pub(crate) fn new(contacts: usize, samples: usize) -> Self {
        Crossings {
            distances: [(); 2].map(|_| vec![vec![[0.0; 2]; samples]; contacts]),
            contacts: vec![Contact::default(); contacts],
            list: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
        }
    }

    pub(crate) fn samples(&self) -> usize {
        self.distances[0].first().map_or(0, Vec::len)
    }

    /// All crossings, contact by contact in increasing time.
    pub(crate) fn list(&self) -> &[OrbitCrossing] {
        &self.list
    }

    #[inline]
    pub(crate) fn piece(&self, contact: usize, sample: usize) -> Piece {
        let [lower, upper] = &self.distances;
        if lower[contact][sample][0] < 0.0 {
            Piece::Lower
        } else if upper[contact][sample][0] > 0.0 {
            Piece::Upper
        } else {
            Piece::Gap
        }
    }

    /// Whether a contact stays in its gap for the whole span.
    pub(crate) fn floats(&self, contact: usize) -> bool {
        self.list.iter().all(|e| e.contact != contact) && self.piece(contact, 0) == Piece::Gap
    }

    /// Local extremes of the distance of a contact from an edge: time over the span, distance, and whether it
    /// is a maximum.
    pub(crate) fn extremes(&self, contact: usize, edge: Edge) -> impl Iterator<Item = (f64, f64, bool)> {
        let d = &self.distances[edge as usize][contact];
        let (m, stencil) = (d.len(), Stencil::get());
        let turns = move |s: usize| d[s][1] * d[(s + 1) % m][1] <= 0.0 && d[s][0].is_finite();
        (0..m).filter(move |&s| turns(s)).filter_map(move |s| {
            let polynomial = stencil.polynomial(s, m, |i| d[i][0]);
            let y = polynomial.extreme()?;
            Some(((s as f64 + 0.5 + y) / m as f64, polynomial.at(y).0, d[s][1] > 0.0))
        })
    }

    /// Locates all crossings of the motion on the grid.
    pub(crate) fn locate(&mut self, grid: &mut Grid<'_>) {
        let stencil = Stencil::get();
        self.list.clear();
        self.q.resize(grid.dof(), 0.0);
        self.v.resize(grid.dof(), 0.0);
        let (m, step) = (grid.samples(), grid.step());
        for s in 0..m {
            grid.state(s, &mut self.q, &mut self.v);
            grid.model.contact(grid.drives(s), &self.q, &self.v, &mut self.contacts);
            for (c, contact) in self.contacts.iter().enumerate() {
                for (edge, distances) in Edge::BOTH.into_iter().zip(&mut self.distances) {
                    distances[c][s] = [edge.distance(contact), step * edge.rate(contact)];
                }
            }
        }
        // The model does not give the rates of inner kinks.
        for c in grid.model.offers().touching(self.contacts.len())..self.contacts.len() {
            for distances in &mut self.distances {
                let d = &mut distances[c];
                for s in 0..m {
                    d[s][1] = 0.5 * (d[(s + 1) % m][0] - d[(s + m - 1) % m][0]);
                }
            }
        }
        for c in 0..self.contacts.len() {
            let mut here = self.piece(c, 0);
            for s in 0..m {
                let next = self.piece(c, (s + 1) % m);
                if here != next {
                    self.cross(c, s, here, next, stencil);
                } else {
                    self.graze(c, s, here, stencil);
                }
                here = next;
            }
        }
    }

    /// Locates the crossings between two samples on different pieces, in the order in which they occur.
    fn cross(&mut self, contact: usize, cell: usize, from: Piece, to: Piece, stencil: &Stencil) {
        let mut here = from;
        while here != to {
            // On the way up the lower edge comes first, on the way down the upper edge.
            let next = if here == Piece::Gap { to } else { Piece::Gap };
            let d = &self.distances[Edge::between(here, next) as usize][contact];
            let polynomial = stencil.polynomial(cell, d.len(), |i| d[i][0]);
            let phi = polynomial.root(-0.5, 0.5);
            self.list.push(OrbitCrossing {
                contact,
                from: here,
                to: next,
                cell,
                phi,
                slope: polynomial.at(phi).1,
            });
            here = next;
        }
    }

    /// Locates an excursion to another piece that begins and ends between two samples.
    fn graze(&mut self, contact: usize, cell: usize, piece: Piece, stencil: &Stencil) {
        let m = self.samples();
        for &edge in Edge::around(piece) {
            let other = edge.beyond(piece);
            let (sign, d) = (edge.sign_on(piece), &self.distances[edge as usize][contact]);
            let ([a, da], [b, db]) = (d[cell], d[(cell + 1) % m]);
            let (a, da, b, db) = (sign * a, sign * da, sign * b, sign * db);
            // Only if the contact moves towards the edge at the first sample and away at the second, and one
            // of the two tangents crosses the edge between the samples.
            if !(da < 0.0 && db > 0.0) || (a + da > 0.0 && b - db > 0.0) {
                continue;
            }
            let polynomial: Polynomial = stencil.polynomial(cell, m, |i| sign * d[i][0]);
            let Some(extreme) = polynomial.extreme().filter(|&y| polynomial.at(y).0 < 0.0) else {
                continue;
            };
            for (from, to, phi) in [
                (piece, other, polynomial.root(-0.5, extreme)),
                (other, piece, polynomial.root(extreme, 0.5)),
            ] {
                self.list.push(OrbitCrossing {
                    contact,
                    from,
                    to,
                    cell,
                    phi,
                    slope: sign * polynomial.at(phi).1,
                });
            }
        }
    }
}
