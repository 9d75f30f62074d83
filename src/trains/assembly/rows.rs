//! Rows of a train: how far each coordinate moves a contact, a bearing or a shaft.

use crate::contact::Nonlinearity;
use crate::model::Channel;
use crate::trains::parts::mesh_part::Kind;
use crate::trains::plan::topology::Gearing;
use crate::trains::plan::train_plan::Plan;
use crate::trains::shape::elements::Entry;
use crate::trains::train_error::TrainError;

/// The inertial coordinates of all bodies.
pub(crate) struct Layout<'p, N> {
    pub(crate) plan: &'p Plan<'p, N>,
    /// Place of the angle of each body that is not locked, and of x and y of each body with a bearing.
    pub(crate) angle: Vec<Option<usize>>,
    pub(crate) centre: Vec<[Option<usize>; 2]>,
    /// Name, unit and inertia of each coordinate.
    pub(crate) coordinates: Vec<Channel>,
    pub(crate) masses: Vec<f64>,
}

/// A sparse row with one entry for each coordinate.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row(pub(crate) Vec<Entry>);

impl Row {
    pub(crate) fn add(&mut self, at: usize, by: f64) {
        match self.0.iter_mut().find(|entry| entry.at == at) {
            Some(entry) => entry.by += by,
            None => self.0.push(Entry { at, by }),
        }
    }
    /// The row without entries that are rounding of a sine or a cosine.
    fn clean(mut self) -> Self {
        let largest = self.0.iter().fold(0.0f64, |most, entry| most.max(entry.by.abs()));
        self.0.retain(|entry| entry.by.abs() > 4.0 * f64::EPSILON * largest);
        self
    }
}

impl<'p, N: Nonlinearity> Layout<'p, N> {
    pub(crate) fn of(plan: &'p Plan<'p, N>) -> Self {
        let (mut coordinates, mut masses) = (Vec::new(), Vec::new());
        let (mut angle, mut centre) = (Vec::new(), Vec::new());
        for (name, body) in plan.topology.bodies {
            let mut place = |axis: &str, unit: &str, mass: f64| {
                coordinates.push(Channel::new(format!("{name} {axis}"), unit));
                masses.push(mass);
                masses.len() - 1
            };
            angle.push((!body.locked).then(|| place("angle", "rad", body.inertia)));
            let x =
                body.bearing.filter(|bearing| !bearing.along_y).map(|bearing| place("x", "m", bearing.mass));
            centre.push([x, body.bearing.map(|bearing| place("y", "m", bearing.mass))]);
        }
        Layout { plan, angle, centre, coordinates, masses }
    }

    /// Adds `lever` times the counterclockwise angle of a body.
    fn turn(&self, row: &mut Row, body: usize, lever: f64) {
        if let Some(angle) = self.angle[body] {
            row.add(angle, lever * self.plan.kinematics.sense(body));
        }
    }
    /// Adds the displacement of the centre of a body along (x, y).
    fn shift(&self, row: &mut Row, body: usize, [x, y]: [f64; 2]) {
        if self.plan.topology.body(body).bearing.is_some() {
            for (at, by) in self.centre[body].into_iter().zip([x, y]) {
                if let Some(at) = at {
                    row.add(at, by);
                }
            }
        } else if self.plan.planets[body].is_some() {
            self.shift_of_pin(row, body, [x, y]);
        }
    }
    /// Adds the displacement of the pin of a planet along (x, y): that of its carrier.
    fn shift_of_pin(&self, row: &mut Row, body: usize, [x, y]: [f64; 2]) {
        if let Some(planet) = &self.plan.planets[body] {
            let (sin, cos) = libm::sincos(planet.angle);
            self.turn(row, planet.carrier, planet.radius * (y * cos - x * sin));
            self.shift(row, planet.carrier, [x, y]);
        }
    }

    /// The row of a mesh, and that of its friction.
    pub(crate) fn mesh(&self, gearing: &Gearing<N>) -> Result<[Row; 2], TrainError> {
        let Plan { topology, kinematics, planets, centres, .. } = self.plan;
        let &Gearing { name, ends: [a, b], carrier, part: mesh, .. } = gearing;
        let [from, to] = if mesh.kind == Kind::FirstInternal { [a, b] } else { [b, a] };
        let [p, q] = [from, to].map(|body| centres[body].unwrap_or_default());
        // The unit vector e along the centres: from the first to the second gear, or from the internal gear.
        let way = if mesh.kind == Kind::External { -1.0 } else { 1.0 };
        let (dx, dy) = (way * (q[0] - p[0]), way * (q[1] - p[1]));
        let far = dx.hypot(dy);
        let moves = |body: usize| topology.body(body).bearing.is_some() || planets[body].is_some();
        if far <= 0.0 && (moves(a) || moves(b)) {
            return Err(TrainError::SameCentre { mesh: name.into() });
        }
        let e = if far > 0.0 { [dx / far, dy / far] } else { [1.0, 0.0] };
        let t = [-e[1], e[0]];
        // 1 if the first gear turns counterclockwise against the line of centres.
        let turns = kinematics.relative(a, carrier).is_none_or(|speed| speed.value() >= 0.0);
        let sense = if turns { 1.0 } else { -1.0 };
        let (sin, cos) = libm::sincos(mesh.pressure_angle);
        let apart = if mesh.kind == Kind::FirstInternal { -sin } else { sin };
        // Rounding errors become 0: they would couple motion along and across the line of action.
        let n = [0, 1].map(|i| sense * cos * t[i] + apart * e[i]);
        let n = n.map(|x| if x.abs() < 4.0 * f64::EPSILON { 0.0 } else { x });
        let [r1, r2] = mesh.radii;
        let across = if mesh.kind == Kind::External { r2 } else { -r2 };
        let row = self.along(n, [(a, sense * r1), (b, sense * across)]);
        // The friction acts along k × n at the pitch point. Its lever about each centre is r tan α.
        let tan = sin / cos;
        let pitch = if mesh.kind == Kind::External { [r1 * tan, r2 * tan] } else { [r1 * tan, -r2 * tan] };
        let pitch = if mesh.kind == Kind::FirstInternal { pitch.map(|r| -r) } else { pitch };
        // The sliding of the flanks at the mean speeds reverses with the sense of rotation.
        let [first, second] = [a, b].map(|body| kinematics.speeds[body].value());
        let way = if first < second { -1.0 } else { 1.0 };
        let friction = self.along([-way * n[1], way * n[0]], [(a, way * pitch[0]), (b, way * pitch[1])]);
        Ok([row, friction])
    }
    /// The row of two bodies along n with levers about their centres.
    fn along(&self, n: [f64; 2], [(a, first), (b, second)]: [(usize, f64); 2]) -> Row {
        let mut row = Row::default();
        self.turn(&mut row, a, first);
        self.turn(&mut row, b, second);
        self.shift(&mut row, a, n);
        self.shift(&mut row, b, n.map(|n| -n));
        row.clean()
    }

    /// The row of the angle of a body, times `lever`.
    pub(crate) fn own(&self, body: usize, lever: f64) -> Row {
        Row(self.angle[body].map(|at| Entry { at, by: lever }).into_iter().collect())
    }
    /// The rows of the counterclockwise angle of a body and of x and y of its centre.
    pub(crate) fn motion(&self, body: usize) -> [Vec<Entry>; 3] {
        let mut rows: [Row; 3] = Default::default();
        self.turn(&mut rows[0], body, 1.0);
        self.shift(&mut rows[1], body, [1.0, 0.0]);
        self.shift(&mut rows[2], body, [0.0, 1.0]);
        rows.map(|row| row.clean().0)
    }
    /// The row of a shaft: the difference of two angles along their rotations.
    pub(crate) fn shaft(&self, [a, b]: [usize; 2]) -> Row {
        Row(self.own(a, 1.0).0.into_iter().chain(self.own(b, -1.0).0).collect())
    }

    /// The rows of the bearing of a body along x and y: against the ground, of a planet against its pin.
    pub(crate) fn bearing(&self, body: usize) -> [Row; 2] {
        [[1.0, 0.0], [0.0, 1.0]].map(|along| {
            let mut row = Row::default();
            self.shift(&mut row, body, along);
            self.shift_of_pin(&mut row, body, along.map(|x| -x));
            row.clean()
        })
    }

    /// The rigid motion: rates of all coordinates over the speed of the reference body.
    pub(crate) fn rigid(&self) -> Vec<f64> {
        let mut rigid = vec![0.0; self.coordinates.len()];
        let speed = |body: usize| self.plan.kinematics.speeds[body].value();
        for (body, at) in self.angle.iter().enumerate() {
            if let Some(at) = at {
                rigid[*at] = speed(body).abs();
            }
        }
        for (centre, planet) in self.centre.iter().zip(&self.plan.planets) {
            let Some(planet) = planet else { continue };
            let (sin, cos) = libm::sincos(planet.angle);
            let speed = speed(planet.carrier) * planet.radius;
            for (at, by) in centre.iter().zip([-speed * sin, speed * cos]) {
                if let Some(at) = at {
                    rigid[*at] = by;
                }
            }
        }
        rigid
    }
}
