//! Trial runs of a scenario that gives an accuracy: the run is repeated on meshes that follow from it, as `run` does,
//! until one is fine enough. What is added by hand after that keeps the mesh.

use super::Session;
use super::mesh::Mesh;
use super::snapshot::Snapshot;
use std::rc::Rc;
use wireloom::mesh::{Adaptation, Next};
use wireloom::session::{DrivenHarness, Ended};

impl Session {
    /// Takes an increment into account, if a trial run is under way.
    pub(super) fn note_errors(&mut self, ended: &Ended) {
        // The start counts where it is all there is.
        let counts = ended.checkpoint.done() != (0, 0) || self.now.harness.schedule.steps.is_empty();
        if let (Mesh::Adapting(adaptation), true) = (&mut self.now.mesh, counts) {
            adaptation.add(&ended.end, ended.checkpoint.state(), &ended.errors);
        }
    }

    /// Ends a trial run, if one is under way; `complete`: it came to the end of the schedule. The run begins anew on a
    /// finer mesh, unless its own is fine enough.
    pub(super) fn end_trial(&mut self, complete: bool) {
        let Mesh::Adapting(mut adaptation) = self.now.mesh.clone() else { return };
        let mut scenario = self.now.harness.scenario.clone();
        let next = adaptation.end_trial(complete, &mut scenario);
        let settled = |adaptation: &Adaptation, harness: &DrivenHarness| {
            let note = adaptation.note(&harness.network);
            let kept = "steps that are added here keep it, while `run` of the saved scenario adapts it to them";
            Mesh::Settled(format!("{note}; {kept}").into())
        };
        if next == Next::Done {
            self.now.mesh = settled(&adaptation, &self.now.harness);
            self.changes.scene = true;
            return;
        }
        let harness = match scenario.build(&self.known.registry) {
            Ok(built) => DrivenHarness::new(scenario, built, &self.monitor),
            Err(faults) => {
                self.now.stop();
                let fault = faults.first().map_or("no mesh could be made", |fault| &fault.message);
                return self.report_failure(fault.to_owned());
            }
        };
        let (harness, mesh) = if next == Next::Trial {
            adaptation.begin_trial(&harness.network);
            (harness.guided(adaptation.guide()), Mesh::Adapting(adaptation))
        } else {
            let mesh = settled(&adaptation, &harness);
            (harness, mesh)
        };
        let Snapshot { files, text, own, by_hand, run, .. } = self.now.clone();
        let mut anew = Snapshot::new(files, text, own, by_hand, Rc::new(harness), run + 1);
        anew.mesh = mesh;
        let unsaved = self.unsaved;
        self.switch_to(anew);
        self.unsaved = unsaved;
    }
}

#[cfg(test)]
mod tests {
    use crate::protocol::{Holding, Request};
    use crate::session::Session;
    use crate::session::tests::{STEPS, Y, opened, session, work};
    use wireloom::session::{IncrementObserver, Monitor};
    use wireloom::{Control, Run};

    /// The Y with a mesh by accuracy.
    fn by_accuracy() -> String {
        let y = Y.replace("max_segment = \"20 mm\"\n", "").replace("segments = 15\n", "");
        format!("{}\n{STEPS}", y.replacen("[sections.trunk]", "[mesh]\naccuracy = \"0.02 %\"\n\n[sections.trunk]", 1))
    }

    /// The run of a text on the mesh of its accuracy, as the program carries it out.
    fn run(text: &str) -> Run {
        let registry = wireloom::registry();
        let (scenario, built) = wireloom::load(text, &registry).expect("no faults");
        let meshed = wireloom::mesh::by_accuracy(scenario, built, &registry, &Monitor::default());
        let (_, built) = meshed.expect("no faults");
        wireloom::run_observed(built, None, &mut IncrementObserver(&mut |_, _| Control::Continue))
    }

    fn mesh_notes(session: &Session) -> Vec<String> {
        session.scene().notes.into_iter().filter(|note| note.contains("accuracy")).collect()
    }

    #[test]
    fn a_scenario_that_gives_an_accuracy_opens_on_the_mesh_of_its_run() {
        // Without its steps the Y hangs at one end and bends so little that the first mesh is fine enough.
        for (text, first_is_fine) in
            [(by_accuracy(), false), (by_accuracy().replace(STEPS, "").replace("0.02 %", "2 %"), true)]
        {
            let expected = run(&text);
            let mut session = opened(&text);
            let first: Vec<u32> = session.scene().branches.iter().map(|branch| branch.nodes).collect();
            let trial = session.busy().expect("it computes");
            assert!(trial.contains("the start (trial run 1 of at most 3"), "{trial}");
            assert!(mesh_notes(&session)[0].ends_with("the mesh is not the final one"), "{:?}", mesh_notes(&session));
            work(&mut session);
            let scene = session.scene();
            let nodes: Vec<u32> = scene.branches.iter().map(|branch| branch.nodes).collect();
            assert_eq!((scene.run == 0, nodes == first), (first_is_fine, first_is_fine), "{nodes:?}, {first:?}");
            // What the run says of its mesh, the page says as well.
            let note = expected.notes.iter().find(|note| note.contains("accuracy")).expect("a note");
            let said = mesh_notes(&session);
            assert!(said.len() == 1 && said[0].starts_with(note.as_str()), "{said:?}, not {note}");
            let end = &session.record().ends[session.record().ends.len() - 1];
            for (own, branch) in end.branches.iter().zip(&expected.steps[expected.steps.len() - 1].branches) {
                assert_eq!(own.s, branch.s, "{}", branch.name);
                if !first_is_fine {
                    assert_eq!(own.position, branch.position, "{}", branch.name);
                }
            }
            assert!(!session.unsaved() && session.undo_labels() == [None, None]);
        }
    }

    #[test]
    fn what_is_added_by_hand_keeps_the_adapted_mesh() {
        let mut session = session(&by_accuracy());
        let nodes = |session: &Session| session.scene().branches.iter().map(|branch| branch.nodes).collect::<Vec<_>>();
        let (before, run) = (nodes(&session), session.scene().run);
        // Two grabs at nodes that are in no way at round lengths.
        for (branch, s) in [("left", 0.171), ("trunk", 0.093)] {
            session.handle(1, Request::Hold { branch: branch.to_owned(), s, how: Holding::Handle });
            work(&mut session);
        }
        session.handle(
            1,
            Request::Target { constraint: "handle 1".to_owned(), position: Some([0.45, 0.1, 0.1]), orientation: None },
        );
        work(&mut session);
        session.handle(1, Request::Drop { constraint: "handle 1".to_owned() });
        assert_eq!((nodes(&session), session.scene().run), (before, run), "{:?}", session.take_changes().said);
        // A setting changes what the mesh has to be fine enough for.
        let value = serde_json::json!(0.02);
        session.handle(1, Request::Set { key: "sections.arm.bending_stiffness".to_owned(), value });
        assert!(mesh_notes(&session)[0].starts_with("trial run 1"), "{:?}", mesh_notes(&session));
        work(&mut session);
        assert!(mesh_notes(&session)[0].starts_with("mesh for an accuracy of 0.02 %"), "{:?}", mesh_notes(&session));
    }

    #[test]
    fn a_trial_run_that_is_stopped_says_so() {
        let mut session = opened(&by_accuracy());
        session.work();
        session.work();
        session.handle(1, Request::Stop);
        assert!(!session.has_work());
        assert!(
            mesh_notes(&session)[0].contains("stopped, so the mesh may be too coarse"),
            "{:?}",
            mesh_notes(&session)
        );
        let run = session.scene().run;
        session.handle(1, Request::Hold { branch: "left".to_owned(), s: 0.17, how: Holding::Pin });
        work(&mut session);
        assert_eq!(session.scene().run, run);
    }
}
