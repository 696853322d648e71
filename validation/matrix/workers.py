"""Processes that ask peers: one crashes or hangs without harm to the others."""

import json
import pathlib
import select
import subprocess
import sys
import threading

LIMIT_S = 120
READINGS = 25  # of one process; a peer may be left in a bad state by a file
HERE = pathlib.Path(__file__).parent


class Worker:
    """One process of one peer, started anew after a crash and now and then."""

    def __init__(self, peer):
        self.peer, self.process, self.left = peer, None, 0

    def ask(self, path, ours):
        if self.left == 0:
            self.stop()
            command = [sys.executable, str(HERE / "ask.py"), self.peer]
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                            stderr=subprocess.DEVNULL, text=True)
            self.left = READINGS
        self.left -= 1
        try:
            self.process.stdin.write(json.dumps([str(path), ours]) + "\n")
            self.process.stdin.flush()
            ready, _, _ = select.select([self.process.stdout], [], [], LIMIT_S)
            line = self.process.stdout.readline() if ready else None
        except BrokenPipeError:
            line = ""
        if line:
            return json.loads(line)
        said = f"has not ended after {LIMIT_S} s"
        if line is not None:
            said = f"crashes ({self.process.wait()})"
        self.left = 0
        return {"failed": said}

    def stop(self):
        if self.process is not None:
            self.process.kill()
            self.process.wait()


class Workers:
    """A worker for each peer and thread."""

    def __init__(self):
        self.mine, self.all = threading.local(), []

    def ask(self, peer, path, ours):
        workers = self.mine.__dict__.setdefault("workers", {})
        if peer not in workers:
            workers[peer] = Worker(peer)
            self.all.append(workers[peer])
        return workers[peer].ask(path, ours)

    def stop(self):
        for worker in self.all:
            worker.stop()
