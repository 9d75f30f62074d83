//! Rows of a train: how far each coordinate moves a contact, a bearing or a shaft.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::{Kind, MeshPart};
use crate::trains::plan::kinematics::Kinematics;
use crate::trains::plan::places::{Planets, centre};
use crate::trains::shape::elements::Entry;
use crate::trains::train_error::TrainError;

/// Where the coordinates of each body are, its planets and its sense of rotation.
pub(crate) struct Layout<'p, N> {
    pub(crate) parts: &'p Parts<N>,
    pub(crate) kinematics: &'p Kinematics,
    pub(crate) planets: &'p Planets,
    /// Place of the angle of each body that is not locked, and of x and y of each body with a bearing.
    pub(crate) angle: Vec<Option<usize>>,
    pub(crate) centre: Vec<[Option<usize>; 2]>,
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

impl<N: Nonlinearity> Layout<'_, N> {
    /// Adds `lever` times the counterclockwise angle of a body.
    fn turn(&self, row: &mut Row, body: usize, lever: f64) {
        if let Some(angle) = self.angle[body] {
            row.add(angle, lever * self.kinematics.sense(body));
        }
    }
    /// Adds the displacement of the centre of a body along (x, y).
    fn shift(&self, row: &mut Row, body: usize, [x, y]: [f64; 2]) {
        if self.parts.bodies[body].1.bearing.is_some() {
            for (at, by) in self.centre[body].into_iter().zip([x, y]) {
                if let Some(at) = at {
                    row.add(at, by);
                }
            }
        } else if self.planets[body].is_some() {
            self.shift_of_pin(row, body, [x, y]);
        }
    }
    /// Adds the displacement of the pin of a planet along (x, y): that of its carrier.
    fn shift_of_pin(&self, row: &mut Row, body: usize, [x, y]: [f64; 2]) {
        if let Some(planet) = &self.planets[body] {
            let (sin, cos) = libm::sincos(planet.angle);
            self.turn(row, planet.carrier, planet.radius * (y * cos - x * sin));
            self.shift(row, planet.carrier, [x, y]);
        }
    }

    /// The row of a mesh, and that of its friction.
    pub(crate) fn mesh(
        &self,
        name: &str,
        [a, b]: [usize; 2],
        mesh: &MeshPart<N>,
    ) -> Result<[Row; 2], TrainError> {
        let [from, to] = if mesh.kind == Kind::FirstInternal { [a, b] } else { [b, a] };
        let [p, q] = [from, to].map(|body| centre(self.parts, self.planets, body));
        // The unit vector e along the centres: from the first to the second gear, or from the internal gear.
        let way = if mesh.kind == Kind::External { -1.0 } else { 1.0 };
        let (dx, dy) = (way * (q[0] - p[0]), way * (q[1] - p[1]));
        let far = dx.hypot(dy);
        let moves = |body: usize| self.parts.bodies[body].1.bearing.is_some() || self.planets[body].is_some();
        if far <= 0.0 && (moves(a) || moves(b)) {
            return Err(TrainError::SameCentre { mesh: name.into() });
        }
        let e = if far > 0.0 { [dx / far, dy / far] } else { [1.0, 0.0] };
        let t = [-e[1], e[0]];
        // 1 if the first gear turns counterclockwise against the line of centres.
        let carrier =
            [a, b].iter().find_map(|&body| self.planets[body].as_ref().map(|planet| planet.carrier));
        let turns = self.kinematics.relative(a, carrier).is_none_or(|speed| speed.value() >= 0.0);
        let sense = if turns { 1.0 } else { -1.0 };
        let (sin, cos) = libm::sincos(mesh.pressure_angle);
        let apart = if mesh.kind == Kind::FirstInternal { -sin } else { sin };
        // Components that are rounding are 0, so that parallel directions stay apart.
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
        let [first, second] = [a, b].map(|body| self.kinematics.speeds[body].value());
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
    /// The row of a shaft: the difference of two angles along their rotations.
    pub(crate) fn shaft(&self, [a, b]: [usize; 2]) -> Row {
        Row(self.own(a, 1.0).0.into_iter().chain(self.own(b, -1.0).0).collect())
    }

    /// The rows of the bearing of a body along x and y: against its pin for a planet, against the ground for
    /// others.
    pub(crate) fn bearing(&self, body: usize) -> [Row; 2] {
        [[1.0, 0.0], [0.0, 1.0]].map(|along| {
            let mut row = Row::default();
            self.shift(&mut row, body, along);
            self.shift_of_pin(&mut row, body, along.map(|x| -x));
            row.clean()
        })
    }

    /// The rigid motion: rates of all coordinates over the speed of the reference body.
    pub(crate) fn rigid(&self, dof: usize) -> Vec<f64> {
        let mut rigid = vec![0.0; dof];
        for (body, at) in self.angle.iter().enumerate() {
            if let Some(at) = at {
                rigid[*at] = self.kinematics.speeds[body].value().abs();
            }
        }
        for (centre, planet) in self.centre.iter().zip(self.planets) {
            let Some(planet) = planet else { continue };
            let (sin, cos) = libm::sincos(planet.angle);
            let speed = self.kinematics.speeds[planet.carrier].value() * planet.radius;
            for (at, by) in centre.iter().zip([-speed * sin, speed * cos]) {
                if let Some(at) = at {
                    rigid[*at] = by;
                }
            }
        }
        rigid
    }
}
