#!/usr/bin/env python3
"""What replays cost a browser: `tests/frames.py PROGRAM [OUT]`.

Prints, for the default run, the source's rocket stage and a net of 21 x 21 knots, how large the page is, how long it
takes from asking for it to its first picture, and how many pictures a second headless Chromium draws while it plays: by the canvas, which
the page takes without a graphics card, and by WebGL computed by the processor, which it does not take. Pictures a second depend on the machine and on what else runs there, so that this is a study
and no test; processor time a picture, all processes of the browser together, depends on the first alone. Needs nothing but
Python and Chromium in the path, or its path in TUMBLENET_BROWSER. Takes a minute and a half beside the runs.
"""

import http.server
import json
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

SCENES = [
    ("default run", []),
    ("rocket stage, 10 s", ["run", "stage-free"]),
    ("21 x 21 knots", ["run", "cubesat-free", "--set", "net.meshes=[20,20]", "--set", "net.mesh_length_m=0.035"]),
]
KINDS = {"canvas": b"swiftshader|", "WebGL": b"no such card|"}
SECONDS = 10

# Counts pictures for some seconds after the first, then tells the server.
COUNT = """
{ const begun = [], plain = draw, tell = what => fetch("/told", { method: "POST", body: JSON.stringify(what) });
  draw = () => {
    const t = performance.now(); plain();
    if (begun.push([t, performance.now() - t]) === 1) tell("first picture");
  };
  const watch = () => {
    if (begun.length < 2 || begun.at(-1)[0] - begun[0][0] < 1000 * %d) return setTimeout(watch, 50);
    const passed = (begun.at(-1)[0] - begun[0][0]) / 1000, drawing = begun.reduce((sum, [, ms]) => sum + ms, 0);
    const kind = flat ? "canvas" : "WebGL";
    tell({ first: begun[0][0], pictures: begun.length - 1, passed, drawing: drawing / begun.length, kind, playing });
  };
  watch(); }
""" % SECONDS
END = b"})();\n</script>"


def served(page, told):
    """A server of one page that hands on what the page tells."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            body = page if self.path == "/" else b""
            self.send_response(200 if body else 404)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def do_POST(self):
            told.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server


def used(root):
    """Processor time of a process and of all that it has begun [s]."""
    parents, times = {}, {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        parents[int(stat.parent.name)], times[int(stat.parent.name)] = int(fields[1]), sum(map(int, fields[11:15]))
    ours = {root}
    while more := {process for process, parent in parents.items() if parent in ours} - ours:
        ours |= more
    return sum(times.get(process, 0) for process in ours) / os.sysconf("SC_CLK_TCK")


def watched(browser, page):
    """What the page told of itself, and the processor time of the browser since its first picture [s]."""
    told = queue.Queue()
    server = served(page, told)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [browser, "--headless", "--no-sandbox", "--no-first-run", "--disable-sync", "--window-size=1280,720"]
        command += ["--disable-background-networking", "--disable-component-update", f"--user-data-dir={profile}"]
        command += ["--enable-unsafe-swiftshader", f"http://127.0.0.1:{server.server_address[1]}/"]
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            told.get(timeout=120)
            before = used(child.pid)
            numbers = told.get(timeout=120)
            return numbers, used(child.pid) - before
        finally:
            child.terminate()
            child.wait()
            server.shutdown()


def main():
    program = Path(sys.argv[1]).resolve()
    out = Path(sys.argv[2] if len(sys.argv) > 2 else tempfile.mkdtemp())
    names = ["chromium", "chromium-browser", "google-chrome"]
    browser = os.environ.get("TUMBLENET_BROWSER") or next(filter(None, map(shutil.which, names)), None)
    if not browser:
        sys.exit("no browser: Chromium in the path, or TUMBLENET_BROWSER")
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    heads = ["page [MB]", "drawn by", "first picture [s]", "pictures/s", "script a picture [ms]", "processor a picture [ms]"]
    print(f"{'':20}" + "  ".join(heads))
    for name, command in SCENES:
        place = out / name.replace(" ", "-").replace(",", "")
        place.mkdir(parents=True, exist_ok=True)
        if not list(place.glob("results/*/replay.html")):
            subprocess.run([program, "--quiet", *command], cwd=place, check=True, stdout=subprocess.DEVNULL)
        page = next(place.glob("results/*/replay.html")).read_bytes()
        assert page.count(END) == 1, "the page's script ends as it did"
        counting = page.replace(END, COUNT.encode() + END)
        for kind, names in KINDS.items():
            told, processor = watched(browser, counting.replace(b"swiftshader|", names, 1))
            if told["kind"] != kind or not told["playing"]:
                sys.exit(f"{name}: asked for {kind}, playing; the page told {told}")
            cells = [len(page) / 1e6, kind, told["first"] / 1e3, told["pictures"] / told["passed"], told["drawing"]]
            cells.append(1e3 * processor / told["pictures"])
            shown = [cell if isinstance(cell, str) else f"{cell:.2f}" for cell in cells]
            print(f"{name:20}" + "  ".join(f"{cell:>{len(head)}}" for cell, head in zip(shown, heads)), flush=True)


if __name__ == "__main__":
    main()
