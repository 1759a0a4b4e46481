"""Sweeps in parts: on this machine, on Dask, on Ray, as a job array; workers that are killed; bad input."""

import hashlib
import importlib.util
import os
import pickle
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import wireloom
from wireloom import _sweep, _wireloom

POINTS = 640
KILLS = int(os.environ.get("WIRELOOM_KILLS", "12"))
"""Workers that are killed; the number of the long test is 100."""

VARY = """
[sweep]
method = "latin-hypercube"
samples = 640
seed = 5
[sweep.vary]
"branches.cable.length" = { mean = "1 m", deviation = "20 mm" }
"constraints.plug-B.position.0" = { from = 0.5, to = 0.7 }
"""


@pytest.fixture
def scenario() -> wireloom.Scenario:
    """A cable with 640 points."""
    return wireloom.loads(wireloom.EXAMPLE + VARY, name="cable.toml")


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Hash of the table that this process computes alone."""
    folder = tmp_path_factory.mktemp("alone")
    scenario = wireloom.loads(wireloom.EXAMPLE + VARY, name="cable.toml")
    return digest(wireloom.sweep(scenario, into=folder))


def digest(sweep: wireloom.Sweep) -> str:
    """Hash of the table of all points."""
    return hashlib.sha256(Path(sweep.compact()).read_bytes()).hexdigest()


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Dask with two worker processes."""
    distributed = pytest.importorskip("distributed", reason="Dask is not installed: pip install distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        yield cluster


def test_the_command_line_writes_the_same_table(
    scenario: wireloom.Scenario, alone: str, tmp_path: Path, program: str
) -> None:
    scenario.save(tmp_path / "cable.toml")
    subprocess.run([program, "sweep", "cable.toml", "--out", "o", "--quiet"], cwd=tmp_path, check=True)
    table = (tmp_path / "o" / "points.parquet").read_bytes()
    assert hashlib.sha256(table).hexdigest() == alone
    # It goes on with what this package has begun.
    task = _sweep.task_of(scenario, str(tmp_path / "parts"), None)
    _wireloom.sweep_part(task, 40, 80, 1)
    subprocess.run([program, "sweep", "cable.toml", "--into", "parts", "--quiet"], cwd=tmp_path, check=True)
    assert digest(wireloom.Sweep(tmp_path / "parts")) == alone


def test_dask_computes_the_same_dataset(
    scenario: wireloom.Scenario, alone: str, tmp_path: Path, cluster: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    from distributed import Client

    with Client(cluster) as client:
        sweep = wireloom.sweep(scenario, into=tmp_path, client=client, points=40, progress=True)
    assert sweep.status().parts == 16
    assert digest(sweep) == alone
    assert f"{POINTS} of {POINTS} points" in capsys.readouterr().err


def test_workers_of_dask_that_are_killed_lose_no_row_and_double_none(
    scenario: wireloom.Scenario, alone: str, tmp_path: Path
) -> None:
    distributed = pytest.importorskip("distributed", reason="Dask is not installed: pip install distributed")
    rng = random.Random(1)
    kills, rounds, over = 0, 0, threading.Event()
    with distributed.LocalCluster(n_workers=0, dashboard_address=None, silence_logs=50) as cluster:
        # Not Dask's own keepers of workers: they give up a worker that ends while it starts.
        words = [sys.executable, "-m", "distributed.cli.dask_worker", cluster.scheduler_address]
        options = ["--no-nanny", "--nthreads=1", "--no-dashboard", f"--local-directory={tmp_path}"]

        def start() -> subprocess.Popen[bytes]:
            return subprocess.Popen([*words, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        workers = [start(), start()]

        def kill() -> None:
            nonlocal kills
            while kills < KILLS and not over.wait(rng.uniform(0.2, 1.5)):
                k = rng.randrange(2)
                workers[k].kill()
                workers[k].wait()
                kills += 1
                workers[k] = start()

        killer = threading.Thread(target=kill)
        killer.start()
        try:
            with distributed.Client(cluster) as client:
                while kills < KILLS:
                    sweep = wireloom.sweep(scenario, into=tmp_path / str(rounds), client=client, points=40)
                    rounds += 1
        finally:
            over.set()
            killer.join()
            for worker in workers:
                worker.kill()
                worker.wait()
    assert sweep.status().parts == 16
    assert all(digest(wireloom.Sweep(tmp_path / str(k))) == alone for k in range(rounds))


def test_ray_computes_the_same_dataset(scenario: wireloom.Scenario, alone: str, tmp_path: Path) -> None:
    if importlib.util.find_spec("ray") is None:
        pytest.skip("Ray is not installed: pip install ray")
    import ray

    ray.init(num_cpus=2, include_dashboard=False, object_store_memory=80 << 20, configure_logging=False)
    try:
        sweep = wireloom.sweep(scenario, into=tmp_path, client=ray, points=40)
    finally:
        ray.shutdown()
    assert sweep.status().parts == 16
    assert digest(sweep) == alone


def test_a_job_array_computes_the_same_dataset_and_the_next_one_what_is_missing(
    scenario: wireloom.Scenario, alone: str, tmp_path: Path
) -> None:
    script = tmp_path / "sweep.sh"
    assert wireloom.slurm(scenario, tmp_path / "parts", script, points=40, jobs=6, options=("--time=1:00:00",)) == 6
    text = script.read_text()
    assert "#SBATCH --array=0-5\n" in text and "#SBATCH --time=1:00:00\n" in text

    def job(index: int) -> int:
        environment = os.environ | {"SLURM_ARRAY_TASK_ID": str(index)}
        return subprocess.run([script], env=environment, cwd="/", check=False).returncode

    with ThreadPoolExecutor(2) as pool:
        assert set(pool.map(job, [5, 1, 3, 1])) == {0}
    sweep = wireloom.Sweep(tmp_path / "parts")
    assert sweep.status().parts == 8
    with pytest.raises(wireloom.RequestError, match="no part has the points 0..40"):
        sweep.compact()
    assert wireloom.slurm(scenario, tmp_path / "parts", script, points=40) == 8
    with ThreadPoolExecutor(2) as pool:
        assert set(pool.map(job, range(8))) == {0}
    assert wireloom.slurm(scenario, tmp_path / "parts", script, points=40) == 0
    assert digest(sweep) == alone


def test_s3_holds_the_same_dataset(
    scenario: wireloom.Scenario, alone: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    moto = pytest.importorskip("moto.server", reason="no local server of S3: pip install 'moto[server]'")
    boto3 = pytest.importorskip("boto3", reason="no client of S3: pip install boto3")
    server = moto.ThreadedMotoServer(port=0, verbose=False)
    server.start()
    try:
        url = "http://{}:{}".format(*server.get_host_and_port())
        for name, value in {
            "AWS_ACCESS_KEY_ID": "key",
            "AWS_SECRET_ACCESS_KEY": "secret",
            "AWS_REGION": "us-east-1",
            "AWS_ENDPOINT": url,
            "AWS_ALLOW_HTTP": "true",
        }.items():
            monkeypatch.setenv(name, value)
        s3 = boto3.client("s3", endpoint_url=url, region_name="us-east-1")
        s3.create_bucket(Bucket="bucket")
        try:
            sweep = wireloom.sweep(scenario, into="s3://bucket/some/where", points=200)
        except wireloom.RequestError as error:
            assert "built without s3://" in str(error)
            pytest.skip("the package is built without the feature `cloud`")
        assert sweep.status().parts == 4
        assert sweep.compact() == "s3://bucket/some/where/points.parquet"
        table = s3.get_object(Bucket="bucket", Key="some/where/points.parquet")["Body"].read()
        assert hashlib.sha256(table).hexdigest() == alone
        with pytest.raises(wireloom.ResultError, match="the parts of another sweep"):
            wireloom.sweep(scenario, into="s3://bucket/some/where", columns=["force"])
    finally:
        server.stop()


def test_files_travel_with_the_scenario(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    # A box far below the cable.
    corners = [f"v {x} {y} {z}" for z in (-2, -1) for y in (0, 1) for x in (0, 1)]
    faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
    (home / "box.obj").write_text("\n".join(corners + [f"f {face}" for face in faces]) + "\n")
    obstacle = '\n[[obstacles]]\nname = "box"\nmesh = "box.obj"\n'
    few = VARY.replace("640", "40")
    scenario = wireloom.loads(wireloom.EXAMPLE + obstacle + few, folder=home)
    assert [str(fault) for fault in scenario.check()] == []
    task = _sweep.task_of(scenario, str(tmp_path / "parts"), None)
    assert list(task[1] or {}) == ["box.obj"]
    (home / "box.obj").unlink()
    _wireloom.sweep_part(pickle.loads(pickle.dumps(task)), 0, 40, 1)
    assert wireloom.Sweep(tmp_path / "parts").status().done == 40


def test_ctrl_c_keeps_the_parts_that_are_done(scenario: wireloom.Scenario, alone: str, tmp_path: Path) -> None:
    def interrupt() -> None:
        while not list(tmp_path.glob("parts/*.parquet")):
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        wireloom.sweep(scenario, into=tmp_path, points=40)
    thread.join()
    done = wireloom.Sweep(tmp_path).status().done
    assert 0 < done < POINTS
    assert digest(wireloom.sweep(scenario, into=tmp_path)) == alone


def test_bad_input_is_an_exception_that_says_what_would_be_right(scenario: wireloom.Scenario, tmp_path: Path) -> None:
    few = wireloom.loads(wireloom.EXAMPLE + VARY.replace("640", "40"))
    place = tmp_path / "parts"
    with pytest.raises(wireloom.RequestError, match="did you mean `force`"):
        wireloom.sweep(few, into=place, columns=["forc"])
    with pytest.raises(wireloom.ScenarioError, match=r"has no \[sweep\]"):
        wireloom.sweep(wireloom.loads(wireloom.EXAMPLE), into=place)
    with pytest.raises(wireloom.RequestError, match="give a folder"):
        wireloom.sweep(few, into="ftp://host/parts")
    with pytest.raises(TypeError, match="distributed.Client"):
        wireloom.sweep(few, into=place, client=3)
    with pytest.raises(ValueError, match="above zero"):
        wireloom.sweep(few, into=place, points=0)
    with pytest.raises(wireloom.ResultError, match="has no sweep.json"):
        wireloom.Sweep(tmp_path / "nowhere").status()
    with pytest.raises(OSError, match="cannot make the folder"):
        wireloom.sweep(few, into="/dev/null/parts")
    assert not place.exists()
    wireloom.sweep(few, into=place)
    with pytest.raises(wireloom.ResultError, match="the parts of another sweep"):
        wireloom.sweep(scenario, into=place)
    task = _sweep.task_of(scenario, str(tmp_path / "other"), None)
    with pytest.raises(wireloom.RequestError, match=r"0\.\.120 would be right"):
        _wireloom.sweep_part(task, 10, 100, 1)
    (part,) = place.glob("parts/*.parquet")
    part.write_bytes(b"PAR1")
    assert wireloom.Sweep(place).status().damaged[0][0].startswith("parts/")
    with pytest.raises(wireloom.ResultError, match="is damaged"):
        wireloom.Sweep(place).compact()
