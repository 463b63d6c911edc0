"""The scan on a cluster of Spark: a master and two workers, started from PySpark's own files, on this machine.

It is skipped, saying so, where PySpark or Java is absent.
"""

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import zipfile
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest
import stiction.plant

pytest.importorskip("pyspark", reason="PySpark is not installed")
if shutil.which("java") is None and "JAVA_HOME" not in os.environ:
    pytest.skip("there is no Java", allow_module_level=True)

from cluster import SPARK, Cluster, Connect, environment, kill  # noqa: E402
from pyspark.sql import functions as F  # noqa: E402

# PySpark warns of newer packages than it knows.
pytestmark = pytest.mark.filterwarnings("ignore::FutureWarning", "ignore::DeprecationWarning", "ignore::ResourceWarning")

#: Loops and days of the demo plant; set both for a larger trial.
LOOPS = int(os.environ.get("STICTION_SPARK_LOOPS", "6"))
DAYS = int(os.environ.get("STICTION_SPARK_DAYS", "3"))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    cluster = Cluster(tmp_path_factory.mktemp("cluster"))
    yield cluster
    cluster.end()


@pytest.fixture(scope="module")
def plant(tmp_path_factory):
    """A demo plant, with a loop of ten times the samples and two that cannot be judged, scanned here."""
    folder = tmp_path_factory.mktemp("plant")
    stiction.plant.demo(folder, loops=LOOPS, days=DAYS)
    first = sorted((folder / "data").glob("*.parquet"))[0]
    table = pq.read_table(first)
    # The loop with ten times as many samples, every value ten times over.
    name = pc.unique(table["tag"])[0].as_py().partition(".")[0]
    own = table.filter(pc.starts_with(table["tag"], name + ".")).to_pylist()
    steps = sorted({row["time"] for row in own})
    step = (steps[1] - steps[0]) / 10
    many = [
        {**row, "tag": row["tag"].replace(name, "FIC9001"), "time": row["time"] + k * step} for row in own for k in range(10)
    ]
    begin = steps[0]
    bad = [{"time": begin, "tag": "FIC9002.OP", "value": 50.0}, {"time": begin, "tag": "FIC9002.PV", "value": 1.0}]
    bad += [{"time": time, "tag": f"FIC9003.{of}", "value": float("nan")} for time in steps[:50] for of in ("OP", "PV")]
    pq.write_table(pa.Table.from_pylist(many + bad, table.schema), folder / "data" / "more.parquet")
    stiction.plant.scan(folder, threads=2)
    return folder


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The installed package as the .zip that a wheel is, so that the executors have it from the driver alone."""
    package = Path(stiction.plant.__file__).parents[1]
    path = tmp_path_factory.mktemp("wheel") / "stiction.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for each in sorted(package.rglob("*")):
            if each.is_file() and "__pycache__" not in each.parts:
                file.write(each, Path("stiction") / each.relative_to(package))
    return path


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """A Python for the executors: this one, to which the package is hidden but by the archive."""
    folder = tmp_path_factory.mktemp("python")
    hide = folder / "sitecustomize.py"
    hide.write_text(
        "import importlib.machinery, sys\n"
        "class Hide:\n"
        "    @staticmethod\n"
        "    def find_spec(name, path=None, target=None):\n"
        "        if name == 'stiction':\n"
        "            spec = importlib.machinery.PathFinder.find_spec(name, [p for p in sys.path if 'deps' in p])\n"
        "            if spec is None:\n"
        "                raise ModuleNotFoundError(\"No module named 'stiction'\", name=name)\n"
        "            return spec\n"
        "sys.meta_path.insert(0, Hide)\n"
    )
    path = folder / "python3"
    path.write_text(f'#!/bin/sh\nPYTHONPATH="{folder}:$PYTHONPATH" exec "{sys.executable}" "$@"\n')
    path.chmod(0o755)
    return path


SIZES = [
    *("--conf", "spark.executor.memory=700m"),
    *("--conf", "spark.ui.enabled=false"),
    *("--conf", "spark.sql.shuffle.partitions=4"),
]


def command(cluster, bare, plant, output, *more, sizes=SIZES):
    arguments = ["--plant", plant, "--output", output, "--input", plant / "data", "--master", cluster.url, *more]
    return subprocess.Popen(
        [sys.executable, "-m", "stiction.plant.spark", *map(str, arguments), *sizes],
        env=environment(PYSPARK_PYTHON=str(bare), PYSPARK_DRIVER_PYTHON=sys.executable),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ran(*arguments, timeout=600, **more):
    process = command(*arguments, **more)
    out, err = process.communicate(timeout=timeout)
    return process.returncode, out, err


def submitted(cluster, bare, wheel, folder, arguments):
    """The job of docs/spark.md, as `spark-submit` starts it."""
    job = folder / "job.py"
    words = [str(each) for each in arguments]
    job.write_text(f"import sys\n\nfrom stiction.plant.spark import main\n\nsys.exit(main({words!r}))\n")
    command = [SPARK / "bin" / "spark-submit", "--master", cluster.url, "--archives", f"{wheel}#deps"]
    command += ["--conf", "spark.executorEnv.PYTHONPATH=./deps", *SIZES, job]
    own = environment(PYSPARK_PYTHON=str(bare), PYSPARK_DRIVER_PYTHON=sys.executable)
    process = subprocess.run(list(map(str, command)), env=own, capture_output=True, text=True, timeout=600)
    return process.returncode, process.stdout, process.stderr


#: What a local scan has otherwise, for it fingerprints files; and what it keeps beside its rows.
NOT_OF_ROWS = ["input_fingerprint", "trace_start", "trace_signal", "trace_unit", "trace_values"]


def traces(folder):
    """All traces of a plant's store, by loop and time."""
    found = [pq.read_table(path) for path in sorted((folder / ".stiction").glob("runs/*/traces-*.parquet"))]
    return pa.concat_tables(found).sort_by([("loop", "ascending"), ("start", "ascending")]).to_pylist()


def rows(table):
    table = pa.table(table)
    table = table.drop_columns([name for name in table.column_names if name in NOT_OF_ROWS])
    return table.sort_by([("loop", "ascending"), ("window_start", "ascending")]).to_pylist()


def written(output):
    return pq.read_table(output, partitioning=None)


@pytest.fixture
def apart(plant, tmp_path):
    """The plant's file alone: what Spark judges is taken into a store of its own."""
    folder = tmp_path / "apart"
    folder.mkdir()
    shutil.copy(plant / "plant.toml", folder)
    (folder / "data").symlink_to(plant / "data")
    return folder


def test_without_the_wheel_the_job_ends_with_an_error(cluster, bare, apart, tmp_path):
    begin = time.monotonic()
    code, out, err = ran(cluster, bare, apart, tmp_path / "out")
    assert code == 1 and out == "" and not (tmp_path / "out").exists()
    assert "cannot use the wheel (ModuleNotFoundError: No module named 'stiction')" in err, err[-2000:]
    assert "ship the wheel with" in err and time.monotonic() - begin < 180


def test_the_rows_are_those_of_the_local_scan_though_driver_and_worker_are_killed(
    cluster, bare, plant, apart, wheel, tmp_path
):
    expected = rows(stiction.plant.windows(plant))
    assert {row["loop"] for row in expected if row["error"]} == {"FIC9002", "FIC9003"}
    out = tmp_path / "out"
    # The driver dies when some of it is written; what is, is whole, and is not judged again.
    process = command(cluster, bare, apart, out, "--wheel", wheel, "--windows", LOOPS)
    err = ""
    while "were judged and written" not in err:
        line = process.stderr.readline()
        assert line, err[-3000:]
        err += line
    process.kill()
    process.communicate()
    first = rows(written(out / "run=0001"))
    assert 0 < len(first) < len(expected)
    process = command(cluster, bare, apart, out, "--wheel", wheel, "--most-errors", "0.5")
    killed = threading.Event()

    def fail():
        # When a Python worker of it judges, with the executor and all it has.
        while process.poll() is None and not killed.is_set():
            found = subprocess.run(["ps", "-eo", "pid,ppid,args"], capture_output=True, text=True).stdout
            if sum("pyspark.daemon" in line or "pyspark/daemon" in line for line in found.splitlines()) >= 2:
                time.sleep(5)
                victim = cluster.workers[0]
                for pid in children(victim.pid, found):
                    try:
                        os.kill(pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
                kill(victim)
                killed.set()
                cluster.work()
            time.sleep(0.5)

    failing = threading.Thread(target=fail)
    failing.start()
    told, err = process.communicate(timeout=900)
    failing.join()
    assert process.returncode == 0, err[-3000:]
    assert killed.is_set()
    second = rows(written(out / "run=0002"))
    assert sorted(first + second, key=key) == expected, told
    # The store of the plant has them, too, with the traces by which a report finds loops that swing together.
    assert rows(stiction.plant.windows(apart)) == expected
    assert traces(apart) == traces(plant)

    # Nothing is judged twice; what changed is.
    data = tmp_path / "data"
    shutil.copytree(plant / "data", data)
    last = sorted(data.glob("2*.parquet"))[-1]
    table = pq.read_table(last)
    tag = next(tag for tag in pc.unique(table["tag"]).to_pylist() if tag.endswith(".OP"))
    more = pc.add(table["value"], pc.multiply(0.25, pc.cast(pc.equal(table["tag"], tag), pa.float64())))
    pq.write_table(table.set_column(table.column_names.index("value"), "value", more), last)
    code, told, err = submitted(cluster, bare, wheel, tmp_path, ["--plant", apart, "--output", out, "--input", data, "--groups"])
    assert code == 0, err[-3000:]
    assert "loops compared in 2026-W10, " in told and list((apart / ".stiction" / "pairs").iterdir())
    assert {row["loop"] for row in rows(written(out / "run=0003"))} == {tag.removesuffix(".OP")}
    code, told, err = ran(cluster, bare, apart, out, "--wheel", wheel, "--input", data, "--explain")
    assert code == 0 and ", 0 windows to be judged" in told, (told, err[-3000:])


def children(pid, listed):
    """The processes below one, of a list of `ps`."""
    known = [tuple(map(int, line.split()[:2])) for line in listed.splitlines()[1:]]
    own, found = [pid], []
    while own:
        parent = own.pop()
        below = [child for child, of in known if of == parent]
        own.extend(below)
        found.extend(below)
    return found


@pytest.fixture(scope="module")
def session():
    from pyspark.sql import SparkSession

    os.environ["PYSPARK_PYTHON"] = sys.executable
    session = (
        SparkSession.builder.master("local[2]")
        .config("spark.ui.enabled", "false")
        .config("spark.sql.session.timeZone", "America/New_York")
        .getOrCreate()
    )
    yield session
    session.stop()


def test_tables_of_every_layout_give_the_same(session, plant):
    from stiction.plant import spark

    loops = "*100[1-3]"
    df = session.read.parquet(str(plant / "data"))
    expected = [row for row in rows(stiction.plant.windows(plant)) if row["loop"].endswith(("1001", "1002", "1003"))]
    name = expected[0]["loop"]
    long = spark.scan(df, plant, loops=loops)
    got = sorted((row.asDict() for row in long.rows.drop(*NOT_OF_ROWS).collect()), key=key)
    assert got == expected and long.plan.loops == 3 and long.errors == 0
    # A column a tag, where tags have the same times.
    one = df.where(df["tag"].startswith(name + "."))
    wide = one.groupBy("time").pivot("tag").agg({"value": "first"})
    found = spark.scan(wide.withColumn("OTHER.OP", wide[f"`{name}.OP`"]), plant, loops=name)
    got = sorted((row.asDict() for row in found.rows.drop(*NOT_OF_ROWS).collect()), key=key)
    assert got == [row for row in expected if row["loop"] == name]
    # What is known, made of the same, is done.
    plan = spark.explain(df, plant, loops=loops, known=long.rows)
    assert (plan.windows, plan.done) == (0, long.windows)
    other = (plant / "plant.toml").read_text().replace('zone = "UTC"', 'zone = "Europe/Berlin"')
    assert spark.explain(df, other, loops=loops, known=long.rows).done == 0
    with pytest.raises(ValueError, match="cast it to timestamp"):
        spark.explain(df.withColumn("time", df["time"].cast("string")), plant)
    with pytest.raises(ValueError, match="include no column of times"):
        spark.explain(df.drop("time"), plant)


def groups(folder):
    return [group.to_dict() for group in stiction.plant.groups(folder)]


def test_loops_that_swing_together_are_found_in_blocks(session, plant, tmp_path, monkeypatch):
    from stiction.plant import spark

    shutil.copy(plant / "plant.toml", tmp_path)
    done = spark.scan(session.read.parquet(str(plant / "data")), tmp_path)
    spark._taken(str(tmp_path), done.rows)
    expected = groups(tmp_path)
    assert expected and expected == groups(plant)
    monkeypatch.setattr(spark, "LOOPS_A_BLOCK", 2)
    # A run before, of other traces, does not count.
    old = done.rows.withColumn("trace_values", F.substring("trace_values", 1, 400)).withColumn("run", F.lit("0001"))
    rows = old.unionByName(done.rows.withColumn("run", F.lit("0002")))
    found = spark.pairs(rows, tmp_path)
    assert (found.week, found.compared) == ("2026-W10", found.loops * (found.loops - 1) // 2) and found.blocks >= 3
    assert list((tmp_path / ".stiction" / "pairs").glob("2026-W10-*.parquet"))
    assert groups(tmp_path) == expected
    # The report took what is there: nothing, if that is so.
    monkeypatch.setattr(spark._core, "plant_most_that_counts", lambda count, loops: -1.0)
    assert spark.pairs(rows, tmp_path, week="2026-W10").kept == 0
    assert groups(tmp_path) == []
    with pytest.raises(ValueError, match="have different windows, such as that of"):
        spark.pairs(rows.where(F.col("loop") != expected[0]["members"][0]["loop"]), tmp_path)
    with pytest.raises(ValueError, match="no window was judged in or before"):
        spark.pairs(rows, tmp_path, week="2020-W10")


@pytest.fixture
def connect(tmp_path):
    pytest.importorskip("grpc", reason="Spark Connect needs grpcio")
    if not list((SPARK / "jars").glob("spark-connect_*")):
        pytest.skip("this PySpark comes without the server of Spark Connect")
    folder = tmp_path / "connect"
    folder.mkdir()
    server = Connect(folder, sys.executable)
    yield server
    server.end()


def test_spark_connect_gives_the_same(connect, bare, plant, apart, wheel, tmp_path):
    out = tmp_path / "out"

    def asked(*more):
        return ran(connect, bare, apart, out, *more, sizes=[])

    code, told, err = asked("--conf", f"spark.sql.execution.pyspark.python={bare}")
    assert code == 1 and told == "" and not out.exists()
    assert "cannot use the wheel (ModuleNotFoundError: No module named 'stiction')" in err, err[-2000:]
    code, _, err = asked("--wheel", wheel)
    assert code == 1 and "Spark Connect cannot send a wheel" in err, err[-2000:]
    code, told, err = asked("--groups", "--most-errors", "0.5")
    assert code == 0 and "loops compared in 2026-W10, " in told, err[-3000:]
    expected = rows(stiction.plant.windows(plant))
    assert rows(written(out)) == expected
    assert rows(stiction.plant.windows(apart)) == expected and traces(apart) == traces(plant)
    assert list((apart / ".stiction" / "pairs").iterdir()) and groups(apart) == groups(plant)
    code, told, err = asked("--explain")
    assert code == 0 and ", 0 windows to be judged" in told, (told, err[-3000:])


def key(row):
    return row["loop"], row["window_start"]
