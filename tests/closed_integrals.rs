//! Closed integrals against the other exact ways.

use gear_dynamics::{Balance, BalanceError, Harmonics, Integrals, NfgPair, NfgParams, NfgReading, Piece, Residual};

/// The error of transmission turns 63 times: on 64 samples it looks like one turn the other way, and must not be taken for it.
#[test]
fn closed_integrals_see_drives_of_the_mesh_order() -> Result<(), BalanceError> {
    for reading in [NfgReading::published(), NfgReading::published_on_base_radius(), NfgReading::exact()] {
        let pair = NfgPair::with_reading(&NfgParams { speed: 120.0, ..NfgParams::table1() }, reading)?;
        let balance = Balance::new(Harmonics::up_to(100));
        let orbit = balance.linearised(&pair, Piece::Lower)?;
        let residual = |integrals| -> Result<Vec<f64>, BalanceError> {
            let mut equations = balance.clone().integrals(integrals).equations(&pair, &orbit)?;
            let x = equations.unknowns(&orbit);
            let mut r = vec![0.0; x.len()];
            equations.residual(&x, &mut r);
            Ok(r)
        };
        let (closed, kinks) = (residual(Integrals::Closed)?, residual(Integrals::Kinks)?);
        let apart = closed.iter().zip(&kinks).fold(0.0f64, |worst, (a, b)| worst.max((a - b).abs()));
        assert!(apart < 1e-10, "{reading:?}: {apart:e}"); // exact ways agree to 1e-10
    }
    Ok(())
}
