//! The studio: a harness in the browser that hands take hold of.
//!
//! A session is a scenario that is being written: what hands do becomes steps of it, every target that was solved becomes an increment,
//! and what is saved is a scenario file that `run` carries out. [`open`] begins one; a [`Studio`] is asked, and tells every tab through its [`Subscription`].

pub mod bench;
pub mod exports;
pub mod frame;
pub mod protocol;
pub mod replay;
pub mod scene;
pub mod server;
mod session;
mod worker;

pub use session::{PROGRAM, SessionInput};
pub use worker::{Outcome, Studio, Subscription, TabMessage, open};

/// The page, in one file: `crates/studio/web/dist/index.html`.
pub const PAGE: &str = include_str!("../web/dist/index.html");

#[cfg(test)]
mod tests {
    use crate::{frame, protocol};
    use ts_rs::TS;

    /// The page's view of the protocol is made from the server's. `WIRELOOM_PROTOCOL=write cargo test -p wireloom-studio protocol` makes it
    /// anew.
    #[test]
    fn the_page_speaks_the_same_protocol() {
        let mut text = String::from(
            "// Made from crates/studio/src/protocol.rs and frame.rs by a test:\n// WIRELOOM_PROTOCOL=write cargo test -p wireloom-studio protocol\n\n",
        );
        let mut declare = |declaration: String| text += &format!("export {declaration}\n\n");
        declare(protocol::Holding::decl());
        declare(protocol::Request::decl());
        declare(protocol::Branch::decl());
        declare(protocol::Joint::decl());
        declare(protocol::Constraint::decl());
        declare(protocol::Obstacle::decl());
        declare(protocol::Form::decl());
        declare(protocol::Setting::decl());
        declare(protocol::Scene::decl());
        declare(protocol::Event::decl());
        declare(protocol::TimelineStep::decl());
        declare(protocol::Timeline::decl());
        declare(protocol::Session::decl());
        declare(protocol::Notice::decl());
        declare(frame::Placed::decl());
        declare(frame::ConstraintFrame::decl());
        declare(frame::ObstacleFrame::decl());
        declare(frame::Tightest::decl());
        declare(frame::Header::decl());
        text += &format!("/** Numbers a node. */\nexport const FLOATS = {};\n", frame::FLOATS);
        let place = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("web/src/protocol.ts");
        if std::env::var_os("WIRELOOM_PROTOCOL").is_some() {
            std::fs::write(&place, &text).expect("written");
        }
        let there = std::fs::read_to_string(&place).unwrap_or_default();
        assert_eq!(there, text, "web/src/protocol.ts is not of today: run this test with WIRELOOM_PROTOCOL=write");
    }
}
