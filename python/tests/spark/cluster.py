"""A cluster of Spark on this machine: a master and workers of one core each, started from PySpark's own files."""

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
        deadline = time.monotonic() + 60
        while True:
            try:
                socket.create_connection(("127.0.0.1", self.port), timeout=1).close()
                break
            except OSError:
                assert time.monotonic() < deadline, "the master does not answer"
                time.sleep(0.2)
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
