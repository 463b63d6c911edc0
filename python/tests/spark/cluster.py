"""Spark on this machine, started from PySpark's own files: a master and workers of one core each, or a server of Spark Connect."""

import os
import signal
import socket
import subprocess
import time
from pathlib import Path

import pyspark

SPARK = Path(pyspark.__file__).parent


def environment(**more):
    """What starts a cluster, which does not know the package: that comes with the wheel."""
    own = {name: value for name, value in os.environ.items() if not name.startswith(("SPARK_", "PYSPARK_"))}
    own.pop("PYTHONPATH", None)
    return {**own, "SPARK_HOME": str(SPARK), "SPARK_LOCAL_IP": "127.0.0.1", **more}


def port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def answers(port):
    """Waits until something answers there."""
    deadline = time.monotonic() + 60
    while True:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1).close()
            return
        except OSError:
            assert time.monotonic() < deadline, "nothing answers"
            time.sleep(0.2)


class Connect:
    """A server of Spark Connect with two cores, whose Python is `python`."""

    def __init__(self, folder, python):
        own = port()
        self.url = f"sc://127.0.0.1:{own}"
        command = [SPARK / "bin" / "spark-submit", "--class", "org.apache.spark.sql.connect.service.SparkConnectServer"]
        command += ["--master", "local[2]", "--conf", f"spark.connect.grpc.binding.port={own}"]
        command += ["--conf", "spark.ui.enabled=false"]
        with open(folder / "log", "w") as log:
            self.process = subprocess.Popen(
                list(map(str, command)),
                cwd=folder,
                env=environment(PYSPARK_PYTHON=str(python)),
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        answers(own)

    def end(self):
        kill(self.process)


class Cluster:
    """A master and workers of one core each, whose Python has pyarrow and NumPy but not this package.

    With `cpus` each worker, and all that it starts, runs on a CPU of its own, as if it were a machine with that one.
    """

    def __init__(self, folder, workers=2, cpus=None):
        self.folder, self.cpus = folder, cpus
        self.port = port()
        self.url = f"spark://127.0.0.1:{self.port}"
        self.workers = []
        self.master = self._start("master.Master", "--host", "127.0.0.1", "--port", self.port, "--webui-port", 0)
        answers(self.port)
        for _ in range(workers):
            self.work()

    def _start(self, name, *arguments, cpu=None):
        command = [str(SPARK / "bin" / "spark-class"), f"org.apache.spark.deploy.{name}", *map(str, arguments)]
        if cpu is not None:
            command = ["taskset", "-c", str(cpu), *command]
        own = self.folder / f"{name.partition('.')[0]}-{len(self.workers)}"
        own.mkdir()
        with open(own / "log", "w") as log:
            return subprocess.Popen(command, cwd=own, env=environment(), stdout=log, stderr=log, start_new_session=True)

    def work(self):
        """Starts another worker."""
        cpu = None if self.cpus is None else self.cpus[len(self.workers)]
        arguments = ["--host", "127.0.0.1", "--cores", 1, "--memory", "1g", "--webui-port", 0, "--work-dir", "."]
        self.workers.append(self._start("worker.Worker", *arguments, self.url, cpu=cpu))

    def end(self):
        for process in [*self.workers, self.master]:
            kill(process)


def kill(process):
    """Ends a process and its own children, as a machine that fails does: without a word."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()
