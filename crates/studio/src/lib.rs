//! The studio: interactive editing of a harness in the browser.
//!
//! A session records a scenario. Interactive operations become its steps, every solved target becomes an increment, and
//! the saved file is a scenario that `run` carries out. [`open`] starts a session; a [`Studio`] takes requests, and
//! sends messages to every tab through its [`Subscription`].

pub mod bench;
pub mod envelope;
pub mod exports;
pub mod frame;
pub mod imported;
pub mod protocol;
pub mod replay;
pub mod scene;
pub mod server;
mod session;
mod sheet;
mod stretches;
mod worker;

pub use session::{MAX_FILE, PROGRAM, SessionFiles, SessionInput, Storage, StoreError};
pub use worker::{Outcome, Studio, Subscription, TabMessage, open};

/// The page, in one file: `crates/studio/web/dist/index.html`.
pub const PAGE: &str = include_str!("../web/dist/index.html");

#[cfg(test)]
mod tests {
    use crate::{envelope, frame, protocol};
    use ts_rs::TS;

    /// The page's protocol types are generated from the server's. Regenerate with `WIRELOOM_PROTOCOL=write cargo test
    /// -p wireloom-studio protocol`.
    #[test]
    fn the_page_speaks_the_same_protocol() {
        let mut text = String::from(
            "// Generated from protocol, frame and envelope in crates/studio/src by a test:\n\
             // WIRELOOM_PROTOCOL=write cargo test -p wireloom-studio protocol\n\n",
        );
        let mut declare = |declaration: String| text += &format!("export {declaration}\n\n");
        declare(protocol::Holding::decl());
        declare(protocol::List::decl());
        declare(protocol::PartKind::decl());
        declare(protocol::StoredMesh::decl());
        declare(protocol::Start::decl());
        declare(protocol::Edit::decl());
        declare(protocol::Opening::decl());
        declare(protocol::ImportFile::decl());
        declare(protocol::Arranged::decl());
        declare(protocol::Request::decl());
        declare(protocol::Branch::decl());
        declare(protocol::Joint::decl());
        declare(protocol::Constraint::decl());
        declare(protocol::Obstacle::decl());
        declare(protocol::Form::decl());
        declare(protocol::MechanismJoint::decl());
        declare(protocol::SectionPart::decl());
        declare(protocol::Setting::decl());
        declare(protocol::Scene::decl());
        declare(protocol::Event::decl());
        declare(protocol::SensitivityLine::decl());
        declare(protocol::Sensitivities::decl());
        declare(protocol::TimelineStep::decl());
        declare(protocol::Timeline::decl());
        declare(protocol::Place::decl());
        declare(protocol::SheetLine::decl());
        declare(protocol::Sheet::decl());
        declare(protocol::Session::decl());
        declare(protocol::TextFault::decl());
        declare(protocol::Document::decl());
        declare(protocol::StartPage::decl());
        declare(protocol::OfferedDraft::decl());
        declare(protocol::Recent::decl());
        declare(protocol::Example::decl());
        declare(protocol::Contents::decl());
        declare(protocol::Module::decl());
        declare(protocol::NotOpened::decl());
        declare(protocol::Imported::decl());
        declare(protocol::Finding::decl());
        declare(protocol::FindingItem::decl());
        declare(protocol::Used::decl());
        declare(protocol::Notice::decl());
        declare(protocol::Placed::decl());
        declare(frame::ConstraintFrame::decl());
        declare(frame::ObstacleFrame::decl());
        declare(frame::Tightest::decl());
        declare(frame::Stretch::decl());
        declare(frame::Violation::decl());
        declare(frame::Header::decl());
        declare(envelope::EnvelopeTube::decl());
        declare(envelope::EnvelopeHeader::decl());
        text += &format!("/** Number of quantities per node. */\nexport const FLOATS = {};\n", frame::FLOATS);
        let place = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("web/src/protocol.ts");
        if std::env::var_os("WIRELOOM_PROTOCOL").is_some() {
            std::fs::write(&place, &text).expect("written");
        }
        let there = std::fs::read_to_string(&place).unwrap_or_default();
        assert_eq!(there, text, "web/src/protocol.ts is out of date: run this test with WIRELOOM_PROTOCOL=write");
    }
}
