//! Disks that are full, folders that may not be written to, readers that have gone: the right exit code and words, and
//! nothing computed is lost.

use crate::{SWEEP, cable};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, ErrorKind};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use wireloom_tests::place::{Ended, Place, ended, kill};
use wireloom_tests::program;

/// A command of `sh`, which finds the program in `$P`.
fn shell(place: &Place, script: &str) -> Ended {
    let mut command = Command::new("sh");
    command.args(["-c", script]).env("P", program()).current_dir(place.path(""));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    ended(command.spawn().expect("sh runs"))
}

/// A limit of the size of a file stands for a full disk: a write fails half way. What has been computed can be taken up
/// again.
#[test]
fn a_run_for_which_the_disk_is_too_small_can_be_resumed() {
    let place = Place::new(&cable(60, "[output]\nincrements = true\npicture = false\n"));
    place.run(&["run", "s.toml", "--out", "whole", "-q"]).says(0, &[]);
    let size = fs::metadata(place.path("whole/result.json")).expect("a result").len();
    // Enough for what it keeps on the way, not for the result; `ulimit` counts in blocks of 512 bytes.
    let most = size / 2 / 512;
    let limited = shell(&place, &format!("trap '' XFSZ; ulimit -f {most}; exec \"$P\" run s.toml --out o"));
    limited.says(3, &["cannot write o/result.json: "]);
    assert!(!place.path("o/result.json").exists(), "half a result is none");
    place.run(&["run", "--resume", "o", "-q"]).says(0, &[]);
    assert!(place.result("o") == place.result("whole"));
}

#[test]
fn a_checkpoint_that_does_not_fit_stops_the_run_and_keeps_what_it_has() {
    let place = Place::new(&cable(20, "[output]\npicture = false\n").replace("segments = 20", "segments = 1500"));
    place.run(&["run", "s.toml", "--out", "whole", "-q"]).says(0, &[]);
    // 100 kB: not enough for a checkpoint.
    let limited = shell(&place, "trap '' XFSZ; ulimit -f 200; exec \"$P\" run s.toml --out o");
    limited.says(3, &["cannot write "]);
    place.run(&["run", "--resume", "o", "-q"]).says(0, &[]);
    assert!(place.result("o") == place.result("whole"));
}

#[test]
fn a_sweep_for_which_the_disk_is_too_small_goes_on_later() {
    let place = Place::new(&cable(1, &SWEEP.replace("200", "2000")));
    place.run(&["sweep", "s.toml", "--out", "whole", "-q"]).says(0, &[]);
    // 100 kB: enough for its parts, not for the table.
    let limited = shell(&place, "trap '' XFSZ; ulimit -f 200; exec \"$P\" sweep s.toml --out o");
    limited.says(3, &["cannot write o/points.parquet: "]);
    assert!(!place.path("o/points.parquet").exists());
    place.run(&["sweep", "s.toml", "--out", "o", "-q"]).says(0, &[]);
    let table = |folder: &str| fs::read(place.path(folder).join("points.parquet")).expect("a table");
    assert!(table("o") == table("whole"));
}

/// A disk that really is full: a file system in memory, of a mount namespace of its own.
#[test]
fn a_full_disk_stops_the_run_and_leaves_what_can_be_resumed() {
    let place = Place::new(&cable(300, "[output]\nincrements = true\nvtk = true\npicture = false\n"));
    fs::create_dir(place.path("disk")).expect("a folder");
    let mount = "mount -t tmpfs -o size=4m tmpfs disk";
    if !Command::new("unshare")
        .args(["-rm", "sh", "-c", mount])
        .current_dir(place.path(""))
        .status()
        .is_ok_and(|s| s.success())
    {
        // Mounting is not allowed here; the tests above cover this case.
        return;
    }
    place.run(&["run", "s.toml", "--out", "whole", "-q"]).says(0, &[]);
    let script = format!(
        "{mount} && \"$P\" run s.toml --out disk/o; echo $? >code; ls disk/o disk/o/.wireloom >there; \
         mount -o remount,size=100m disk && \"$P\" run --resume disk/o -q && cp -r disk/o o"
    );
    let mut command = Command::new("unshare");
    command.args(["-rm", "sh", "-c", &script]).env("P", program()).current_dir(place.path(""));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let ended = ended(command.spawn().expect("unshare runs"));
    ended.says(0, &["error: cannot write disk/o/", "No space left on device"]);
    assert_eq!(place.text("code"), "3\n");
    assert!(place.text("there").contains("origin") && !place.text("there").contains("partial"));
    assert!(place.result("o") == place.result("whole"));
}

/// Program as an ordinary user: for `root` no folder is read-only.
fn unprivileged(place: &Place, arguments: &[&str]) -> Ended {
    let mut command = place.command(arguments);
    if fs::metadata("/proc/self").is_ok_and(|own| std::os::unix::fs::MetadataExt::uid(&own) == 0) {
        /// Id of the user `nobody`.
        const NOBODY: u32 = 65534;
        let own = place.path("wireloom");
        fs::copy(program(), &own).expect("a copy that anybody may run");
        command = Command::new(&own);
        command.args(arguments).current_dir(place.path("")).uid(NOBODY).gid(NOBODY);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    }
    // Until another test that starts a program at this moment has let go of the copy, it is "busy".
    loop {
        match command.spawn() {
            Err(error) if error.kind() == ErrorKind::ExecutableFileBusy => std::thread::yield_now(),
            begun => return ended(begun.expect("the program runs")),
        }
    }
}

fn allow(place: &Place, name: &str, mode: u32) {
    fs::set_permissions(place.path(name), fs::Permissions::from_mode(mode)).expect("permissions");
}

#[test]
fn a_folder_that_may_not_be_written_to_is_told_of_before_the_work_begins() {
    let place = Place::new(&cable(20_000, ""));
    place.file("w.toml", cable(1, SWEEP));
    let kbl = wireloom_tests::root().join("crates/import/tests/small.kbl");
    fs::copy(kbl, place.path("k.kbl")).expect("a copy");
    allow(&place, "", 0o755);
    for folder in ["o", "o/.wireloom"] {
        let path = place.path(folder);
        fs::create_dir_all(&path).expect("a folder");
        allow(&place, folder, 0o555);
        for command in [&["run", "s.toml", "--out", "o"][..], &["sweep", "w.toml", "--out", "o"]] {
            unprivileged(&place, command).says(3, &["cannot write in the folder o: Permission denied"]);
        }
        if folder == "o" {
            unprivileged(&place, &["import", "kbl", "k.kbl", "-o", "o/i.toml"]).says(3, &["cannot write o/i.toml: "]);
        }
        allow(&place, folder, 0o755);
    }
    allow(&place, "s.toml", 0o000);
    unprivileged(&place, &["check", "s.toml", "w.toml"]).says(3, &["cannot read s.toml: Permission denied"]);
}

#[test]
fn a_reader_that_has_gone_disturbs_nobody() {
    let place = Place::new(&cable(3, SWEEP));
    let commands: [(&[&str], &str); 5] = [
        (&["run", "s.toml", "--out", "o"], "o/result.json"),
        (&["sweep", "s.toml", "--out", "w"], "w/points.parquet"),
        (&["check", "s.toml"], "s.toml"),
        (&["compare", "s.toml", "--segments", "10,20,40"], "s.toml"),
        (&["models"], "s.toml"),
    ];
    for (arguments, left) in commands {
        // It reads a line and goes.
        let mut child = place.command(arguments).spawn().expect("the program runs");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("its output")).read_line(&mut line).expect("a line");
        let now = ended(child);
        now.says(0, &[]);
        assert!(!line.is_empty() && place.path(left).exists(), "{arguments:?}: {line}");
        // It has never been there; nor has anybody who listens to faults.
        let mut child = place.command(arguments).spawn().expect("the program runs");
        drop((child.stdout.take(), child.stderr.take()));
        assert_eq!(child.wait().expect("ended").code(), Some(0), "{arguments:?}");
    }
    let mut child = place.command(&["check", "absent.toml"]).spawn().expect("the program runs");
    drop((child.stdout.take(), child.stderr.take()));
    assert_eq!(child.wait().expect("ended").code(), Some(3));
}

#[test]
fn output_that_cannot_be_written_ends_with_3_after_the_files_are() {
    let place = Place::new(&cable(3, SWEEP));
    let commands: [(&[&str], &str); 8] = [
        (&["run", "s.toml", "--out", "o"], "o/result.json"),
        (&["sweep", "s.toml", "--out", "w"], "w/points.parquet"),
        (&["report", "w"], "w/report.html"),
        (&["check", "s.toml"], "s.toml"),
        (&["compare", "s.toml", "--segments", "10,20,40", "--report", "c.html"], "c.html"),
        (&["models"], "s.toml"),
        (&["schema"], "s.toml"),
        (&["explain", "branches.length"], "s.toml"),
    ];
    for (arguments, left) in commands {
        let full = File::options().write(true).open("/dev/full").expect("Linux");
        let ended = ended(place.command(arguments).stdout(full).spawn().expect("the program runs"));
        ended.says(3, &["cannot write to standard output: "]);
        assert!(place.path(left).exists(), "{arguments:?}");
    }
}

/// A studio that is killed has its draft; one that cannot keep it says so and goes on.
#[test]
fn a_killed_studio_leaves_no_partial_file_that_is_in_the_way() {
    let place = Place::new(&cable(1, ""));
    let start = || {
        let mut child = place.command(&["studio", "s.toml", "--no-open"]).spawn().expect("the program runs");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("its output")).read_line(&mut line).expect("an address");
        assert!(line.starts_with("http://"), "{line}");
        child
    };
    kill(start());
    let states =
        || fs::read_dir(place.path("state/wireloom")).expect("a folder").map(|entry| entry.expect("an entry").path());
    let kept = states().find(|path| path.extension().is_some_and(|kind| kind == "json")).expect("what it remembers");
    // A link where the next one writes: it is removed, not followed.
    place.file("home/.bashrc", "export PATH\n");
    place.link(kept.with_extension("partial").strip_prefix(place.path("")).unwrap().to_str().unwrap(), "home/.bashrc");
    kill(start());
    assert_eq!(place.text("home/.bashrc"), "export PATH\n");
    assert!(states().all(|path| path.extension().is_none_or(|kind| kind != "partial")));
}
