//! The instrument in a browser tab: files that the page hands over are measured in a worker, and the
//! report and its exports come back. Nothing leaves the machine.
//!
//! A [`Tab`] measures files and gives their results in every form; a [`Request`] is what the page
//! says of a file. In WebAssembly `host.rs` makes functions of these for the page, with two buffers
//! for what they take and give, and reads the file piece by piece through the page. The page itself
//! is in the folder `page`, and `.ci/web` makes one file of both.

#[cfg(target_arch = "wasm32")]
mod host;
mod measure;
mod outputs;
mod request;
mod sample;
mod tab;

pub use measure::Cure;
pub use outputs::Output;
pub use request::Request;
pub use tab::{Answer, Tab};
