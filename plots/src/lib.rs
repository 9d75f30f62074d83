//! Pictures of gear dynamics: one call makes a [`Panel`] from a result of `gear-dynamics`, a [`Picture`] holds panels and
//! is saved as SVG.
//!
//! | picture | call |
//! |---|---|
//! | time history with the contact state shaded | [`history`] |
//! | phase portrait with the gap | [`phase_portrait`] |
//! | amplitude spectrum, over the frequency or over named orders | [`spectrum`], [`order_spectrum`] |
//! | amplitudes over order and speed | [`order_map`], [`waterfall`] |
//! | natural frequencies over the speed | [`campbell`] |
//! | bifurcation diagram | [`bifurcation`] |
//! | branch with stability and located points | [`branch`] |
//! | map over two parameters, located boundary on it | [`map`], [`rattle_map`], [`category_map`], [`Panel::boundary`] |
//! | band of an ensemble | [`band`] |
//! | mode of a train | [`mode`] |
//! | mesh stiffness | [`stiffness`] |
//!
//! Every axis states its unit. Series differ in colour and in dashes or form, colours of maps grow in lightness: pictures
//! are read in grey and by the colour-blind. Empty data and numbers that are not finite are errors that name them.
//!
//! ```
//! use gear_dynamics::branches::{BranchPoint, Continuation, Family};
//! use gear_dynamics::trains::SpurPair;
//! use gear_dynamics_plots::{Picture, branch};
//! let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05])?.parts()?.build("driver", 1.0)?;
//! let line = Continuation::new(0.8, 1.0).run(&Family::over(&pair, ["speed"])?, None)?;
//! let panel = branch(&[&line], ["mesh frequency [1]", "peak-to-peak deflection [1]"], BranchPoint::peak_to_peak)?;
//! let picture = Picture::from(panel.title("spur pair"));
//! assert!(picture.to_svg().contains(">fold</text>"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod draw;
mod error;
mod panel;
mod picture;
mod pictures;
mod svg;

pub use crate::draw::colours::Theme;
pub use crate::draw::layers::Mark;
pub use crate::error::PlotError;
pub use crate::panel::Panel;
pub use crate::picture::Picture;
pub use crate::pictures::band::band;
pub use crate::pictures::bifurcation::bifurcation;
pub use crate::pictures::branch::branch;
pub use crate::pictures::campbell::campbell;
pub use crate::pictures::map::{category_map, map, rattle_map};
pub use crate::pictures::modes::mode;
pub use crate::pictures::motion::{history, phase_portrait};
pub use crate::pictures::spectra::{order_map, order_spectrum, spectrum, waterfall};
pub use crate::pictures::stiffness::stiffness;
