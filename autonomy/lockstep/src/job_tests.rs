//! Jobs of a mapping session and their owners: the end of a session, the quality of its map, and results that come too late or from elsewhere.

use crate::loops_tests::{SESSION, StackRun, finish, promptly};
use crate::replay;
use messages::{CommandKind, Input, JobDone, JobId, JobOwner, JobResult, PoseGraph};
use stack::Stack;
use vocab::Span;

/// The result of a job that waits to be returned to the stack.
fn take(run: &mut StackRun, owner: JobOwner) -> Option<JobDone> {
    let index = run.done.iter().position(|done| done.id().owner == owner)?;
    run.done.remove(index)
}

/// Ends a session with loops. Returns the result of relinearising its graph, which the session waits for.
fn end(run: &mut StackRun) -> JobDone {
    run.finished = None;
    assert_eq!(run.command(finish()), None);
    let done = take(run, JobOwner::Relinearisation).expect("the graph is relinearised");
    assert!(run.finished.is_none(), "the map is saved after that");
    done
}

fn give(run: &mut StackRun, done: JobDone) {
    run.step(run.at, Input::JobDone(done));
}

/// The graph that is being saved. The save then fails, so that the session goes on.
fn saved_graph(run: &mut StackRun) -> PoseGraph {
    let finished = run.finished.take().expect("the map is saved");
    let job = run.saving.take().expect("in a job");
    give(run, job.failed("the disk is full"));
    finished.graph.as_ref().clone()
}

/// Greatest distance between the same keyframes of two graphs, metres.
fn apart(a: &PoseGraph, b: &PoseGraph) -> f64 {
    assert_eq!(a.nodes.len(), b.nodes.len());
    let gap = |(a, b): (&messages::GraphNode, &messages::GraphNode)| {
        let [a, b] = [a, b].map(|node| geometry::vec_from_plain(node.map_from_keyframe.position));
        (a - b).norm()
    };
    a.nodes.iter().zip(&b.nodes).map(gap).fold(0.0, f64::max)
}

#[test]
fn a_finished_map_has_the_relinearised_poses_or_those_from_before() {
    let mut run = StackRun::walked(false, promptly);
    // The job fails, ...
    let job = end(&mut run).id();
    give(&mut run, job.failed("the solver broke"));
    assert!(run.notices.iter().any(|text| text.contains("the solver broke")), "{:?}", run.notices);
    let failed = saved_graph(&mut run);
    // Published poses are off by at most 5 mm.
    assert!(apart(&failed, &run.graph) < 6e-3);
    // ... returns the poses of another graph, ...
    let number = end(&mut run).number;
    give(&mut run, JobDone { number, result: JobResult::Relinearisation(Ok(Vec::new())) });
    assert_eq!(apart(&saved_graph(&mut run), &failed), 0.0);
    // ... or never ends. Its late result is ignored.
    let (late, since) = (end(&mut run), run.at);
    while run.finished.is_none() {
        assert!(run.at - since < Span::from_millis(11_000));
        run.step(run.at + Span::from_millis(50), Input::Tick);
    }
    let before = run.digest.hex();
    give(&mut run, late);
    assert_eq!(run.digest.hex(), before);
    assert_eq!(apart(&saved_graph(&mut run), &failed), 0.0);
    // The job succeeds.
    let done = end(&mut run);
    let JobResult::Relinearisation(Ok(poses)) = done.result.clone() else { panic!("{done:?}") };
    give(&mut run, done);
    let relinearised = saved_graph(&mut run);
    assert!(apart(&relinearised, &failed) > 0.0);
    let positions = relinearised.nodes.iter().map(|node| node.map_from_keyframe.position);
    assert!(positions.eq(poses.iter().map(|pose| pose.position)));
    assert_eq!(replay(run.log.iter().cloned(), &mut Stack::new()).hex(), run.digest.hex());
}

#[test]
fn a_session_goes_on_only_when_its_own_save_fails() {
    let mut run = StackRun::walked(false, promptly);
    let done = end(&mut run);
    // Loops are not changed any more while the graph is relinearised.
    let (from, to) = (vocab::KeyframeId(0), vocab::KeyframeId(5));
    assert!(run.command(CommandKind::RejectLoop { from, to }).is_some_and(|text| text.contains("No map")));
    give(&mut run, done);
    let job = run.saving.expect("the map is saved");
    for other in [
        JobId { number: job.number + 1, ..job }.failed("of another"),
        JobId { owner: JobOwner::Relocalisation, ..job }.failed("of another"),
    ] {
        give(&mut run, other);
    }
    assert!(run.command(CommandKind::StartMapping(SESSION)).is_some(), "it is still being saved");
    saved_graph(&mut run);
    assert!(run.notices.last().is_some_and(|text| text.contains("the disk is full")), "{:?}", run.notices);
    assert!(run.notices.iter().all(|text| !text.contains("of another")), "{:?}", run.notices);
    assert_eq!(run.command(CommandKind::StartMapping(SESSION)), None, "it runs");
}

#[test]
fn quality_is_computed_by_one_job_at_a_time_and_forgotten_with_its_session() {
    let count =
        |run: &StackRun| run.done.iter().filter(|done| done.id().owner == JobOwner::MapQuality).count();
    let run = StackRun::walking(false, promptly);
    assert!(run.qualities.len() > 5, "every two seconds: {}", run.qualities.len());
    assert!(run.qualities.windows(2).all(|pair| pair[0].revision < pair[1].revision));
    let Some(last) = run.qualities.last() else { panic!("none") };
    assert!(last.revision <= run.graph.revision && last.covered_m2 > 50.0, "{last:?}");

    let mut late = StackRun::walking(false, |_| Vec::new());
    assert_eq!(count(&late), 1);
    let Some(done) = take(&mut late, JobOwner::MapQuality) else { panic!("not started") };
    late.done.clear();
    assert_eq!(late.command(CommandKind::DiscardMapping), None);
    let before = late.digest.hex();
    give(&mut late, done);
    assert_eq!((late.digest.hex(), late.qualities.len()), (before, 0));
}

#[test]
fn the_result_of_another_owner_is_ignored() {
    let mut run = StackRun::walking(false, |_| Vec::new());
    let Some(own) = take(&mut run, JobOwner::LoopClosing) else { panic!("nothing is compared") };
    let before = run.digest.hex();
    for owner in [
        JobOwner::MapSaving,
        JobOwner::MapExtension,
        JobOwner::MapSearch,
        JobOwner::Relinearisation,
        JobOwner::Localisation,
        JobOwner::Relocalisation,
        JobOwner::Disambiguation,
    ] {
        give(&mut run, JobId { owner, number: own.number }.failed("of another"));
        assert_eq!(run.digest.hex(), before, "{owner:?}");
    }
    assert_eq!(
        run.stack.take_compute_job(JobId { owner: JobOwner::MapSearch, ..own.id() }).map(|_| ()),
        None
    );
    give(&mut run, own);
    assert_eq!(run.decisions.len(), 1, "its owner still waits for it");
}
