# SPDX-License-Identifier: MIT
"""The program isoshade as a child process: started with a list of arguments, never by a shell, and polled until it has
ended."""
import os
import shutil
import signal
import subprocess
import tempfile
import time

from .tables import Refused


def find(named):
    """Returns the program's path: that of the preferences, or the one in PATH."""
    path = shutil.which(os.path.expanduser(named) if named else "isoshade")
    if not path:
        where = f"{named} is not a program" if named else "isoshade is not in PATH"
        raise Refused(f"{where}; set it in the add-on's preferences")
    return path


def has_option(path, command, option):
    """True if a command of this version has an option."""
    try:
        said = subprocess.run([path, command, "--help"], stdin=subprocess.DEVNULL, capture_output=True, timeout=60, check=False).stdout
    except (OSError, subprocess.SubprocessError) as error:
        raise Refused(f"{path} cannot be started: {error}") from None
    return option in said.decode("utf-8", "replace").split()


def argument(path):
    """Returns a path that no program mistakes for an option."""
    return os.path.join(os.curdir, path) if path.startswith("-") else path


class Job:
    """Running commands, one after another until one fails. finish(job) is called after the last one and returns the message
    to show."""

    def __init__(self, what, commands, blender, finish):
        self.what, self.finish, self.started = what, finish, time.monotonic()
        self.out, self.err = tempfile.TemporaryFile(), tempfile.TemporaryFile()
        self.environment = dict(os.environ, ISOSHADE_BLENDER=blender)
        self.commands = list(commands)
        self.start()

    def start(self):
        command = self.commands.pop(0)
        try:
            # A new session, so that its child processes end with it.
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=self.out, stderr=self.err,
                                            env=self.environment, start_new_session=True)
        except (OSError, ValueError) as error:
            raise Refused(f"{command[0]} cannot be started: {error}") from None

    def ended(self):
        if self.process.poll() == 0 and self.commands:
            self.start()
        return self.process.poll() is not None

    def wait(self):
        self.process.wait()
        while not self.ended():
            self.process.wait()

    def cancel(self):
        self.commands.clear()
        if not self.ended():
            try:
                os.killpg(self.process.pid, signal.SIGTERM)
            except (OSError, AttributeError):
                self.process.terminate()

    def seconds(self):
        return time.monotonic() - self.started

    @staticmethod
    def text(file):
        file.seek(0)
        return file.read().decode("utf-8", "replace")

    def code(self):
        return self.process.returncode

    def output(self):
        return self.text(self.out)

    def complaint(self):
        """Returns the error message of isoshade: its last line."""
        lines = [line.strip() for line in self.text(self.err).splitlines() if line.strip()]
        if self.code() < 0:
            return f"{self.what} was ended (signal {-self.code()})"
        return lines[-1] if lines else f"{self.what}: exit code {self.code()}"
