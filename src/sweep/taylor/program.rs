//! The tape of a shape as instructions for lanes.

use crate::contact::edge::Edge;
use crate::ode::probe::ChannelKind;
use crate::ode::taylor::expansion::dependence::{TimeSum, time_sums};
use crate::ode::taylor::expansion::plan::EdgeColumn;
use crate::sweep::taylor::still::{Still, Stills};
use crate::tape::form::Form;
use crate::tape::operations::{FormId, Op, Tape};

/// Where a number stands: in a column, with one coefficient for each order, or among the numbers without
/// higher orders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Place {
    Column(usize),
    Still(usize),
}

/// Computes the next coefficient of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Rule {
    /// constant + Σ weight × column + Σ weight × still number. Only order 0 has constant and still numbers.
    /// `like`: a column before it and the factor 1 or -1, by which it has the same higher orders.
    Sum {
        columns: Vec<(usize, f64)>,
        stills: Vec<(usize, f64)>,
        constant: f64,
        like: Option<(usize, f64)>,
    },
    /// Product of two columns; the place of its factors.
    Product {
        a: usize,
        b: usize,
        place: usize,
    },
    /// Still number × column.
    Scaled(usize, usize),
    Quotient(Place, usize),
    Exp(usize),
    Ln(usize),
    /// The cosine is the column after the sine.
    SinCos(usize),
    /// The one of several numbers that belongs to the chosen piece.
    Choice {
        selector: usize,
        among: Vec<Place>,
    },
}

/// A rule with its result column.
#[derive(Debug)]
pub(super) struct Instruction {
    pub(super) rule: Rule,
    pub(super) out: usize,
    /// Whether a distance or a channel needs it: it is evaluated in the highest order, too.
    pub(super) late: bool,
}

/// The algebra of a shape, ready for lanes. The first columns are coordinates, then velocities.
#[derive(Debug)]
pub(crate) struct Program {
    pub(super) dof: usize,
    pub(super) columns: usize,
    /// Number of products.
    pub(super) products: usize,
    /// Waves that are needed, with their columns.
    pub(super) waves: Vec<(usize, usize)>,
    pub(super) instructions: Vec<Instruction>,
    pub(super) accelerations: Vec<Place>,
    /// For each contact the columns of the distances from its lower and from its upper edge.
    pub(super) distances: Vec<[Option<usize>; 2]>,
    /// The columns of the measured channels.
    pub(super) channels: Vec<usize>,
    pub(super) stills: Stills,
    /// First contact and number of contacts of each selector.
    pub(super) selectors: Vec<(usize, usize)>,
    /// Sums of columns that vary with the time alone.
    pub(super) time_sums: Vec<TimeSum>,
    /// The tape, for the check of steps.
    pub(super) tape: Tape,
}

/// A program while it is written.
struct Writer<'t> {
    tape: &'t Tape,
    program: Program,
    /// The place of each slot; `None` if nothing needs it.
    places: Vec<Option<Place>>,
}

impl Program {
    /// `waves`: number of drives that vary; the others are constants of a lane. `kinds`: the channels that
    /// are measured.
    ///
    /// # Errors
    /// The name of an operation that lanes do not have.
    pub(crate) fn new(tape: &Tape, waves: usize, kinds: &[ChannelKind]) -> Result<Self, &'static str> {
        let (n, inputs) = (tape.dof, tape.inputs());
        let measured = kinds.iter().filter_map(|kind| match *kind {
            ChannelKind::Deflection(i) => Some(tape.measured[i][0]),
            ChannelKind::Force(i) => Some(tape.measured[i][1]),
            ChannelKind::Coordinate(_) | ChannelKind::Velocity(_) => None,
        });
        let needed = tape.needed_with(&measured.collect::<Vec<FormId>>());
        let mut writer = Writer {
            tape,
            places: vec![None; inputs + tape.ops.len()],
            program: Program {
                dof: n,
                columns: 2 * n,
                products: 0,
                waves: Vec::new(),
                instructions: Vec::new(),
                accelerations: Vec::new(),
                distances: Vec::new(),
                channels: Vec::new(),
                stills: Stills::default(),
                selectors: Vec::new(),
                time_sums: Vec::new(),
                tape: tape.clone(),
            },
        };
        for slot in 0..2 * n {
            writer.places[slot] = Some(Place::Column(slot));
        }
        for drive in (0..tape.drives).filter(|d| needed[2 * n + d]) {
            let place = if drive < waves {
                let column = writer.take(1);
                writer.program.waves.push((drive, column));
                Place::Column(column)
            } else {
                Place::Still(writer.program.stills.keep(Still::Drive(drive)))
            };
            writer.places[2 * n + drive] = Some(place);
        }
        for (i, (op, _)) in tape.ops.iter().enumerate().filter(|(i, _)| needed[inputs + i]) {
            if let Some(place) = writer.place_of_op(op)? {
                writer.places[inputs + i] = Some(place);
                if matches!(op, Op::SinCos(_))
                    && let Some(cosine) = writer.places.get_mut(inputs + i + 1)
                {
                    *cosine = Some(match place {
                        Place::Column(sine) => Place::Column(sine + 1),
                        Place::Still(sine) => Place::Still(sine + 1),
                    });
                }
            }
        }
        let accelerations = tape.accelerations.iter().map(|&form| writer.form(form)).collect();
        let distances = tape.distances.iter().map(|both| both.map(|form| Some(writer.column(form?))));
        let distances = distances.collect();
        let channels = kinds.iter().map(|kind| match *kind {
            ChannelKind::Coordinate(i) => i,
            ChannelKind::Velocity(i) => n + i,
            ChannelKind::Deflection(i) => writer.column(tape.measured[i][0]),
            ChannelKind::Force(i) => writer.column(tape.measured[i][1]),
        });
        let channels = channels.collect();
        let places = |slot: u32| writer.places[slot as usize].and_then(Place::column).unwrap_or(0) as u32;
        let sums = time_sums(tape, |drive| drive >= waves).into_iter();
        let time_sums = sums.map(|sum| sum.of_columns(places)).collect();
        let mut program = Program { accelerations, distances, channels, time_sums, ..writer.program };
        program.mark_late();
        Ok(program)
    }

    /// The edges of the contacts, with the columns of their distances.
    pub(super) fn edges(&self) -> Vec<EdgeColumn> {
        let of_contact = |(contact, both): (usize, &[Option<usize>; 2])| {
            let column = move |(edge, column): (Edge, &Option<usize>)| {
                Some(EdgeColumn { contact, edge, column: (*column)?, sign: 1.0 })
            };
            Edge::BOTH.into_iter().zip(both).filter_map(column).collect::<Vec<_>>()
        };
        self.distances.iter().enumerate().flat_map(of_contact).collect()
    }

    /// What has no series where its operand is 0; `None` if all operations have one.
    pub(super) fn singular(&self) -> Option<&'static str> {
        self.instructions.iter().find_map(|instruction| match instruction.rule {
            Rule::Quotient(..) => Some(Op::DIVISION),
            Rule::Ln(_) => Some(Op::LOGARITHM),
            _ => None,
        })
    }

    /// Marks the instructions that distances and channels need.
    fn mark_late(&mut self) {
        let mut late = vec![false; self.columns];
        let wanted = self.distances.iter().flatten().flatten().chain(&self.channels);
        wanted.for_each(|&column| late[column] = true);
        for instruction in self.instructions.iter_mut().rev() {
            let pair = matches!(instruction.rule, Rule::SinCos(_)) && late[instruction.out + 1];
            instruction.late = late[instruction.out] || pair;
            if instruction.late {
                instruction.rule.columns().into_iter().for_each(|column| late[column] = true);
            }
        }
    }
}

impl Rule {
    /// The columns that the rule reads.
    fn columns(&self) -> Vec<usize> {
        match self {
            Rule::Sum { columns, like, .. } => {
                let like = like.iter().map(|(column, _)| *column);
                columns.iter().map(|(column, _)| *column).chain(like).collect()
            }
            Rule::Product { a, b, .. } => vec![*a, *b],
            Rule::Scaled(_, a) | Rule::Exp(a) | Rule::Ln(a) | Rule::SinCos(a) => vec![*a],
            Rule::Quotient(a, b) => a.column().into_iter().chain([*b]).collect(),
            Rule::Choice { among, .. } => among.iter().filter_map(|place| place.column()).collect(),
        }
    }
}

impl Place {
    fn column(self) -> Option<usize> {
        match self {
            Place::Column(column) => Some(column),
            Place::Still(_) => None,
        }
    }
}

impl Writer<'_> {
    fn take(&mut self, count: usize) -> usize {
        self.program.columns += count;
        self.program.columns - count
    }

    /// The column that a rule computes: a new one, or that of the same rule before.
    fn rule(&mut self, rule: Rule) -> Place {
        if let Some(known) = self.program.instructions.iter().find(|known| known.rule == rule) {
            return Place::Column(known.out);
        }
        let out = self.take(if matches!(rule, Rule::SinCos(_)) { 2 } else { 1 });
        self.program.instructions.push(Instruction { rule, out, late: false });
        Place::Column(out)
    }

    /// The column of a product: a new one, or that of the same product before.
    fn product(&mut self, a: usize, b: usize) -> Place {
        let known = self.program.instructions.iter().find_map(|instruction| match instruction.rule {
            Rule::Product { a: x, b: y, .. } if (x, y) == (a, b) => Some(Place::Column(instruction.out)),
            _ => None,
        });
        known.unwrap_or_else(|| {
            self.program.products += 1;
            self.rule(Rule::Product { a, b, place: self.program.products - 1 })
        })
    }

    /// The column of a sum. The distances from both edges of a gap, and what its flanks read, differ in order
    /// 0 and in sign alone.
    fn sum(&mut self, columns: Vec<(usize, f64)>, stills: Vec<(usize, f64)>, constant: f64) -> Place {
        let like = self.program.instructions.iter().find_map(|instruction| {
            let Rule::Sum { columns: known, like: None, .. } = &instruction.rule else { return None };
            let times = |factor: f64| known.iter().map(move |(column, weight)| (*column, factor * weight));
            let factor = [1.0, -1.0].into_iter().find(|factor| times(*factor).eq(columns.iter().copied()))?;
            (!known.is_empty()).then_some((instruction.out, factor))
        });
        let rule = Rule::Sum { columns, stills, constant, like };
        self.rule(rule)
    }

    fn still(&mut self, still: Still) -> Place {
        Place::Still(self.program.stills.keep(still))
    }

    /// The place of a form: that of its only slot, or of the sum.
    fn form(&mut self, form: FormId) -> Place {
        let Form { constant, terms } = &self.tape.forms[form];
        let (mut columns, mut stills) = (Vec::new(), Vec::new());
        for &(slot, weight) in terms {
            match self.places[slot as usize] {
                Some(Place::Column(column)) => merge(&mut columns, column, weight),
                Some(Place::Still(still)) => merge(&mut stills, still, weight),
                None => unreachable!("operands come first"),
            }
        }
        match (&columns[..], &stills[..]) {
            ([(column, 1.0)], []) if *constant == 0.0 => Place::Column(*column),
            ([], [(still, 1.0)]) if *constant == 0.0 => Place::Still(*still),
            ([], _) => self.still(Still::Sum(*constant, stills)),
            _ => self.sum(columns, stills, *constant),
        }
    }

    /// The column of a form, also if the form does not vary.
    fn column(&mut self, form: FormId) -> usize {
        let place = match self.form(form) {
            Place::Still(still) => self.sum(Vec::new(), vec![(still, 1.0)], 0.0),
            place => place,
        };
        place.column().unwrap_or(0)
    }

    /// The place of the result of an operation; `None` if it has none of its own.
    fn place_of_op(&mut self, op: &Op) -> Result<Option<Place>, &'static str> {
        use Place::{Column, Still as At};
        Ok(Some(match op {
            Op::Cos => return Ok(None),
            Op::Kink(what) => return Err(what),
            Op::Sum(a) => self.form(*a),
            Op::Product(a, b) => match (self.form(*a), self.form(*b)) {
                (Column(a), Column(b)) => self.product(a.min(b), a.max(b)),
                (At(a), At(b)) => self.still(Still::Product(a, b)),
                (At(a), Column(b)) | (Column(b), At(a)) => self.rule(Rule::Scaled(a, b)),
            },
            Op::Quotient(a, b) => match (self.form(*a), self.form(*b)) {
                (a, Column(b)) => self.rule(Rule::Quotient(a, b)),
                (At(a), At(b)) => self.still(Still::Quotient(a, b)),
                (Column(a), At(b)) => {
                    let one = self.program.stills.keep(Still::Sum(1.0, Vec::new()));
                    let per = self.program.stills.keep(Still::Quotient(one, b));
                    self.rule(Rule::Scaled(per, a))
                }
            },
            Op::Choice { contact, count, forms } => {
                let among: Vec<Place> = forms.iter().map(|&form| self.form(form)).collect();
                let selectors = &mut self.program.selectors;
                let selector = selectors.iter().position(|of| *of == (*contact, *count));
                let selector = selector.unwrap_or_else(|| {
                    selectors.push((*contact, *count));
                    selectors.len() - 1
                });
                let stills =
                    among.iter().map(|place| if let At(still) = place { Some(*still) } else { None });
                match stills.collect() {
                    Some(among) => self.still(Still::Choice { selector, among }),
                    None => self.rule(Rule::Choice { selector, among }),
                }
            }
            Op::Sqrt(a) => match self.form(*a) {
                At(a) => self.still(Still::Sqrt(a)),
                Column(_) => return Err("a root of something that varies"),
            },
            Op::Power(a, p, parity) => match self.form(*a) {
                At(a) => self.still(Still::Power(a, *p, *parity)),
                Column(_) => return Err("a power of something that varies"),
            },
            Op::Exp(a) => match self.form(*a) {
                At(a) => self.still(Still::Exp(a)),
                Column(a) => self.rule(Rule::Exp(a)),
            },
            Op::Ln(a) => match self.form(*a) {
                At(a) => self.still(Still::Ln(a)),
                Column(a) => self.rule(Rule::Ln(a)),
            },
            Op::SinCos(a) => match self.form(*a) {
                At(a) => {
                    let sine = self.program.stills.push(Still::Sin(a));
                    self.program.stills.push(Still::Cos(a));
                    At(sine)
                }
                Column(a) => self.rule(Rule::SinCos(a)),
            },
        }))
    }
}

/// Adds a term to a sum.
fn merge(terms: &mut Vec<(usize, f64)>, place: usize, weight: f64) {
    match terms.iter_mut().find(|(of, _)| *of == place) {
        Some((_, sum)) => *sum += weight,
        None => terms.push((place, weight)),
    }
}
