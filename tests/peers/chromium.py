# SPDX-License-Identifier: MIT
"""A page in Chromium without a window, spoken to over two pipes in the words of the DevTools protocol; the standard
library alone. What is drawn is drawn by software GL, on any machine."""
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

# ANGLE on Mesa's llvmpipe is what `render --with gl` draws with where there is no graphics card; SwiftShader is Chromium's own.
DRIVERS = {
    "mesa": ["--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist"],
    "swiftshader": ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
}


def sandbox_words():
    """Chromium puts what it shows into sandboxes, but refuses to begin as root, which it cannot put into any; isoshade's
    own switch says where it shall go without, such as in a container that forbids namespaces."""
    is_off = os.environ.get("ISOSHADE_SANDBOX") == "off"
    return ["--no-sandbox"] if is_off or os.geteuid() == 0 else []


class Chromium:
    """seconds: how long an answer, or what is waited for, may take. within: the folder in which it gets one of its own."""

    def __init__(self, driver="mesa", size=(1200, 800), program=None, seconds=120, within=None):
        self.seconds, self.deadline = seconds, time.monotonic() + seconds
        self.number, self.buffer, self.events = 0, b"", []
        program = program or os.environ.get("ISOSHADE_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser") \
            or shutil.which("google-chrome")
        if not program:
            raise FileNotFoundError("no chromium in the PATH (ISOSHADE_CHROMIUM names one)")
        self.folder = tempfile.mkdtemp(prefix="isoshade-chromium.", dir=within)
        try:
            self.start(program, driver, size)
        except BaseException:
            shutil.rmtree(self.folder, ignore_errors=True)
            raise

    def start(self, program, driver, size):
        ours_in, theirs_out = os.pipe()
        theirs_in, ours_out = os.pipe()

        def give_pipes():  # the browser reads descriptor 3 and writes descriptor 4
            high = [os.dup2(theirs_in, 60), os.dup2(theirs_out, 61)]
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        self.process = subprocess.Popen(
            [program, "--headless", *sandbox_words(), "--remote-debugging-pipe", "--no-first-run", "--disable-background-networking",
             "--disable-component-update", "--hide-scrollbars", f"--user-data-dir={self.folder}", f"--window-size={size[0]},{size[1]}",
             *DRIVERS[driver], "about:blank"],
            env={**os.environ, "TMPDIR": tempfile.gettempdir()},  # a whole path, wherever this runs
            preexec_fn=give_pipes, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs_in)
        os.close(theirs_out)
        self.read_from, self.write_to = ours_in, ours_out
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.call("Page.enable")
        self.call("Runtime.enable")

    def receive(self):
        while b"\0" not in self.buffer:
            left = self.deadline - time.monotonic()
            if left <= 0 or not select.select([self.read_from], [], [], left)[0]:
                raise TimeoutError("the browser gave no answer in time")
            part = os.read(self.read_from, 1 << 20)
            if not part:
                raise RuntimeError("the browser ended" + ("" if "--no-sandbox" in self.process.args else
                                   "; where it may make no sandboxes, --no-sandbox starts it without"))
            self.buffer += part
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, **parameters):
        self.number += 1
        self.deadline = time.monotonic() + self.seconds
        message = {"id": self.number, "method": method, "params": parameters}
        if hasattr(self, "session"):
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.write_to, data):]
        while True:
            answer = self.receive()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            if "method" in answer:
                self.events.append(answer)

    def browser(self, method):
        """A command for the browser instead of the page."""
        session = self.__dict__.pop("session")
        try:
            return self.call(method)
        finally:
            self.session = session

    def evaluate(self, expression):
        """The value of an expression, awaited where it is a promise."""
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise RuntimeError(details.get("exception", {}).get("description") or details["text"])
        return result["result"].get("value")

    def open(self, path, until="true"):
        """Loads a file and waits until an expression holds."""
        url = path if "://" in path else "file://" + os.path.abspath(path)
        self.call("Page.navigate", url=url)
        self.wait(f"location.href !== 'about:blank' && ({until})")

    def wait(self, expression):
        end = time.monotonic() + self.seconds
        while True:
            try:
                # What the page does not have yet may come.
                if self.evaluate(f"(() => {{ try {{ return Boolean({expression}); }} catch {{ return false; }} }})()"):
                    return
            except RuntimeError as problem:
                # Of the page before, which went away with its context while it was asked.
                if not any(word in str(problem) for word in ("context", "target navigated")):
                    raise
            if time.monotonic() > end:
                raise TimeoutError(f"the page never came to: {expression}")
            time.sleep(0.02)

    def mouse(self, kind, x, y, button="left", **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button,
                  buttons=0 if kind == "mouseReleased" else {"left": 1, "right": 2, "none": 0}[button], clickCount=1, **more)

    def drag(self, start, end, steps=8, button="left"):
        self.mouse("mouseMoved", *start, button="none")
        self.mouse("mousePressed", *start, button=button)
        for i in range(1, steps + 1):
            self.mouse("mouseMoved", *(a + (b - a) * i / steps for a, b in zip(start, end)), button=button)
        self.mouse("mouseReleased", *end, button=button)

    def key(self, key, code=None, modifiers=0):
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key, modifiers=modifiers)

    def screenshot(self, path, kind="png", quality=None):
        import base64
        more = {"quality": quality} if quality else {}
        data = self.call("Page.captureScreenshot", format=kind, **more)["data"]
        with open(path, "wb") as f:
            f.write(base64.b64decode(data))

    def close(self):
        try:
            self.call("Browser.close")
        except (RuntimeError, OSError, TimeoutError):
            pass
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.read_from)
        os.close(self.write_to)
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *problem):
        self.close()
