use super::*;

fn follow() -> (JobWatch, watch::Receiver<Progress>, Arc<Stop>) {
    let stop = Arc::new(Stop::default());
    let (sender, receiver) = watch::channel(Progress::default());
    (JobWatch::new(stop.clone(), sender), receiver, stop)
}

#[test]
fn stages_add_up_over_visits_and_steps_stay_inside() {
    let (watch, _, _) = follow();
    watch.stage(Stage::Read);
    watch.step(Some("decode"));
    watch.step(Some("decode"));
    watch.stage(Stage::Solve);
    watch.stage(Stage::Read);
    let figures = watch.finish();
    let names: Vec<_> = figures.iter().map(|f| (f.stage, f.visit_count, f.steps.len())).collect();
    assert_eq!(names, [("read", 2, 1), ("solve", 1, 0)]);
    assert_eq!(figures[0].steps[0].visit_count, 2);
    assert!(figures[0].seconds >= figures[0].steps[0].seconds);
}

#[test]
fn a_step_outside_any_stage_is_dropped() {
    let (watch, _, _) = follow();
    watch.step(Some("decode"));
    watch.step(None);
    assert_eq!(watch.finish(), []);
}

#[test]
fn progress_never_falls_and_never_says_done() {
    let (watch, receiver, _) = follow();
    let mut last = 0;
    for done in [0.1, 0.5, 0.2, f32::NAN, f32::INFINITY, 2.0, -1.0] {
        watch.progress(done);
        let percent = receiver.borrow().percent;
        assert!(percent >= last && percent < 100, "{percent} after {last}");
        last = percent;
    }
    assert_eq!(last, 92);
}

#[test]
fn a_cancel_outranks_a_shutdown() {
    let (watch, _, stop) = follow();
    assert!(!watch.canceled());
    stop.set(StopReason::Canceled);
    stop.set(StopReason::Shutdown);
    assert!(watch.canceled());
    assert_eq!(stop.reason(), Some(StopReason::Canceled));
}

#[test]
fn memory_and_cpu_are_told_on_linux() {
    if cfg!(target_os = "linux") {
        assert!(peak_memory_bytes().unwrap() > 1 << 20);
        assert!(cpu_seconds() > 0.0);
    }
}
