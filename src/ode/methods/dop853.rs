//! The Dormand-Prince method of order 8.

use crate::ode::driver::drive;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::methods::adaptive::{Adaptive, Method};
use crate::ode::outcome::Finish;
use crate::ode::stepping::control::Task;
use crate::ode::stepping::engine::{Engine, Estimates, Tableau};
use crate::ode::stepping::vector::Vector;

/// Runge-Kutta method of order 8 by Dormand and Prince, adaptive.
///
/// Error estimates of orders 5 and 3, dense output of order 7. Source: Hairer, Nørsett & Wanner I, Sect. II.5
/// and II.6; coefficients as in the authors' published code. Where an estimate exceeds by far the one that
/// follows from the step before, as at a kink, the two are not combined to a smaller one.
///
/// Recommended for gears: with located edges the trajectory is smooth between edges, and a high order is
/// efficient. Behind the edge of a contact law with a fractional power, as Hertz's, the error estimate is too
/// low: the first step there may exceed the tolerance a hundredfold. [`Taylor`](crate::Taylor) does not.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, State, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let end = Dop853::new().rtol(1e-12).atol(1e-14).end(&spring, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
/// assert!((end.q[0] - 1f64.cos()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Dop853 = Adaptive<DormandPrince8>;

/// The tableau of [`Dop853`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DormandPrince8;

impl Method for DormandPrince8 {
    fn run(task: Task<'_>) -> Result<Finish, IntegrateError> {
        drive::<DormandPrince8>(task)
    }
}

impl Tableau for DormandPrince8 {
    const ADAPTIVE: bool = true;
    const SLOTS: usize = 16;
    const EVALUATIONS: u64 = 11;
    const END: usize = 12;
    const DENSE: usize = 7;
    const DENSE_EVALUATIONS: u64 = 3;
    const EXPONENT: f64 = 1.0 / 8.0;
    const FACTORS: [f64; 2] = [0.333, 6.0];
    const BETA: f64 = 0.03;
    const NODES: &'static [f64] = &table::C;
    const PROBE: usize = 8;

    #[inline(always)]
    fn attempt<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>) {
        use table::{A2, A3, A4, A5, A6, A7, A8, A9, A10, A11, A12, B};
        e.drive_nodes::<DormandPrince8>();
        e.stage_at::<FIXED, _>(0, 1, &A2);
        e.stage_at::<FIXED, _>(1, 2, &A3);
        e.stage_at::<FIXED, _>(2, 3, &A4);
        e.stage_at::<FIXED, _>(3, 4, &A5);
        e.stage_at::<FIXED, _>(4, 5, &A6);
        e.stage_at::<FIXED, _>(5, 6, &A7);
        e.stage_at::<FIXED, _>(6, 7, &A8);
        e.stage_at::<FIXED, _>(7, 8, &A9);
        e.stage_at::<FIXED, _>(8, 9, &A10);
        e.stage_at::<FIXED, _>(9, 10, &A11);
        e.stage_at::<FIXED, _>(10, 11, &A12);
        e.advance(&B);
    }
    /// The error is |e5|²/√(|e5|² + 0.01 |e3|²), which combines both estimates. This formula is valid for a
    /// smooth force, and its value is too low in a step that contains a kink. A rough estimate shows such
    /// a step. The error is then |e5|, or |e3| if that is rough and larger.
    #[inline(always)]
    fn error<V: Vector>(e: &mut Engine<'_, V>) -> f64 {
        let norms @ [e5, e3] = e.norms([&table::E5, &table::E3]);
        let both = (e5 * e5 + 0.01 * e3 * e3).sqrt();
        let error = if both == 0.0 { 0.0 } else { e5 * e5 / both };
        e.estimates = Estimates { h: e.ends.h(), norms };
        let Some(before) = e.before else { return error };
        let [rough5, rough3] = rough(&before, &e.estimates);
        error.max(if rough5 || rough3 { e5 } else { 0.0 }).max(if rough3 { e3 } else { 0.0 })
    }
    fn dense<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>) {
        use table::{A14, A15, A16, D4, D5, D6, D7};
        e.ends.drive(0.1);
        e.stage::<FIXED, _>(13, &A14);
        e.ends.drive(0.2);
        e.stage::<FIXED, _>(14, &A15);
        e.ends.drive(7.0 / 9.0);
        e.stage::<FIXED, _>(15, &A16);
        e.dense_row(3, &D4);
        e.dense_row(4, &D5);
        e.dense_row(5, &D6);
        e.dense_row(6, &D7);
    }
}

/// An estimate that exceeds the one that follows from the step before by this factor shows a force that is
/// not smooth `[1]`.
const ROUGH: f64 = 100.0;

/// Whether the estimates e5 and e3 show a force that is not smooth. In a smooth motion they follow h⁶ and h⁴.
#[inline(always)]
fn rough(before: &Estimates, made: &Estimates) -> [bool; 2] {
    let square = (made.h / before.h).powi(2);
    let ([e5, e3], [old5, old3]) = (made.norms, before.norms);
    [e5 > ROUGH * square * square * square * old5, e3 > ROUGH * square * square * old3]
}

/// Rows of pairs (column, coefficient) without zeros; columns count from 0.
#[rustfmt::skip]
mod table {
    use crate::ode::stepping::tableau_row::TableauRow;
    pub const C: [f64; 11] = [
        0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726, 1.0/3.0,
        0.25, 4.0/13.0, 0.6512820512820513, 0.6, 6.0/7.0, 1.0,
    ];
    pub const A2: TableauRow<1> = [
        (0, 0.05260015195876773),
    ];
    pub const A3: TableauRow<2> = [
        (0, 0.0197250569845379), (1, 0.0591751709536137),
    ];
    pub const A4: TableauRow<2> = [
        (0, 0.02958758547680685), (2, 0.08876275643042054),
    ];
    pub const A5: TableauRow<3> = [
        (0, 0.2413651341592667), (2, -0.8845494793282861), (3, 0.924834003261792),
    ];
    pub const A6: TableauRow<3> = [
        (0, 0.037037037037037035), (3, 0.17082860872947386), (4, 0.12546768756682242),
    ];
    pub const A7: TableauRow<4> = [
        (0, 0.037109375), (3, 0.17025221101954405), (4, 0.06021653898045596), (5, -0.017578125),
    ];
    pub const A8: TableauRow<5> = [
        (0, 0.03709200011850479), (3, 0.17038392571223998), (4, 0.10726203044637328), (5, -0.015319437748624402),
        (6, 0.008273789163814023),
    ];
    pub const A9: TableauRow<6> = [
        (0, 0.6241109587160757), (3, -3.3608926294469414), (4, -0.868219346841726), (5, 27.59209969944671),
        (6, 20.154067550477894), (7, -43.48988418106996),
    ];
    pub const A10: TableauRow<7> = [
        (0, 0.47766253643826434), (3, -2.4881146199716677), (4, -0.590290826836843), (5, 21.230051448181193),
        (6, 15.279233632882423), (7, -33.28821096898486), (8, -0.020331201708508627),
    ];
    pub const A11: TableauRow<8> = [
        (0, -0.9371424300859873), (3, 5.186372428844064), (4, 1.0914373489967295), (5, -8.149787010746927),
        (6, -18.52006565999696), (7, 22.739487099350505), (8, 2.4936055526796523), (9, -3.0467644718982196),
    ];
    pub const A12: TableauRow<9> = [
        (0, 2.273310147516538), (3, -10.53449546673725), (4, -2.0008720582248625), (5, -17.9589318631188),
        (6, 27.94888452941996), (7, -2.8589982771350235), (8, -8.87285693353063), (9, 12.360567175794303),
        (10, 0.6433927460157636),
    ];
    pub const B: TableauRow<8> = [
        (0, 0.054293734116568765), (5, 4.450312892752409), (6, 1.8915178993145003), (7, -5.801203960010585),
        (8, 0.3111643669578199), (9, -0.1521609496625161), (10, 0.20136540080403034), (11, 0.04471061572777259),
    ];
    pub const A14: TableauRow<8> = [
        (0, 0.056167502283047954), (6, 0.25350021021662483), (7, -0.2462390374708025), (8, -0.12419142326381637),
        (9, 0.15329179827876568), (10, 0.00820105229563469), (11, 0.007567897660545699), (12, -0.008298),
    ];
    pub const A15: TableauRow<8> = [
        (0, 0.03183464816350214), (5, 0.028300909672366776), (6, 0.053541988307438566), (7, -0.05492374857139099),
        (10, -0.00010834732869724932), (11, 0.0003825710908356584), (12, -0.00034046500868740456), (13, 0.1413124436746325),
    ];
    pub const A16: TableauRow<8> = [
        (0, -0.42889630158379194), (5, -4.697621415361164), (6, 7.683421196062599), (7, 4.06898981839711),
        (8, 0.3567271874552811), (12, -0.0013990241651590145), (13, 2.9475147891527724), (14, -9.15095847217987),
    ];
    pub const E3: TableauRow<8> = [
        (0, -0.18980075407240762), (5, 4.450312892752409), (6, 1.8915178993145003), (7, -5.801203960010585),
        (8, -0.4226823213237919), (9, -0.1521609496625161), (10, 0.20136540080403034), (11, 0.02265179219836082),
    ];
    pub const E5: TableauRow<8> = [
        (0, 0.01312004499419488), (5, -1.2251564463762044), (6, -0.4957589496572502), (7, 1.6643771824549864),
        (8, -0.35032884874997366), (9, 0.3341791187130175), (10, 0.08192320648511571), (11, -0.022355307863886294),
    ];
    pub const D4: TableauRow<12> = [
        (0, -8.428938276109013), (5, 0.5667149535193777), (6, -3.0689499459498917), (7, 2.38466765651207),
        (8, 2.117034582445028), (9, -0.871391583777973), (10, 2.2404374302607883), (11, 0.6315787787694688),
        (12, -0.08899033645133331), (13, 18.148505520854727), (14, -9.194632392478356), (15, -4.436036387594894),
    ];
    pub const D5: TableauRow<12> = [
        (0, 10.427508642579134), (5, 242.28349177525817), (6, 165.20045171727028), (7, -374.5467547226902),
        (8, -22.113666853125306), (9, 7.733432668472264), (10, -30.674084731089398), (11, -9.332130526430229),
        (12, 15.697238121770845), (13, -31.139403219565178), (14, -9.35292435884448), (15, 35.81684148639408),
    ];
    pub const D6: TableauRow<12> = [
        (0, 19.985053242002433), (5, -387.0373087493518), (6, -189.17813819516758), (7, 527.8081592054236),
        (8, -11.57390253995963), (9, 6.8812326946963), (10, -1.0006050966910838), (11, 0.7777137798053443),
        (12, -2.778205752353508), (13, -60.19669523126412), (14, 84.32040550667716), (15, 11.99229113618279),
    ];
    pub const D7: TableauRow<12> = [
        (0, -25.69393346270375), (5, -154.18974869023643), (6, -231.5293791760455), (7, 357.6391179106141),
        (8, 93.40532418362432), (9, -37.45832313645163), (10, 104.0996495089623), (11, 29.8402934266605),
        (12, -43.53345659001114), (13, 96.32455395918828), (14, -39.17726167561544), (15, -149.72683625798564),
    ];
}
