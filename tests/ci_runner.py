# SPDX-License-Identifier: MIT
"""Imitates the runner of a CI service: ci_runner.py FILE.yml FOLDER. Runs the commands of the file's only job in
FOLDER, which stands for the checkout, with the variables and the shell of the service. Of the service's own actions
it knows the one that keeps files: a missing file is a failure. Ends with the exit code of the first step that fails.
FOLDER.summary gets the summary of a GitHub job."""
import os
import pathlib
import re
import subprocess
import sys

import yaml


def run(script, folder, shell, **variables):
    """Runs lines in a shell of their own; returns its exit code."""
    environment = {"PATH": os.environ["PATH"], "HOME": os.environ["HOME"], "CI": "true", **variables}
    return subprocess.run([*shell, "-c", script], cwd=folder, env=environment, check=False,
                          stdin=subprocess.DEVNULL).returncode


def expanded(text):
    """Puts a link for the one expression that the recipe may have."""
    text = re.sub(r"\$\{\{ steps\.\w+\.outputs\.artifact-url \}\}", "https://artifacts.invalid/1", text)
    assert "${{" not in text, f"unknown expression: {text}"
    return text


def kept(paths, folder):
    """Returns 1 if a path to keep is missing."""
    missing = [path for path in paths if not (folder / path).exists()]
    for path in missing:
        print(f"to keep, but missing: {path}")
    return 1 if missing else 0


def github(job, folder):
    failed = 0
    summary = folder.with_name(folder.name + ".summary")
    summary.write_text("")
    for step in job["steps"]:
        assert step.get("if", "always()") == "always()", f"unknown condition: {step['if']}"
        if failed and "if" not in step:
            continue
        code = 0
        if "run" in step:
            variables = {name: expanded(value) for name, value in step.get("env", {}).items()}
            code = run(expanded(step["run"]), folder, ("sh", "-e"), GITHUB_ACTIONS="true", GITHUB_WORKSPACE=str(folder),
                       GITHUB_STEP_SUMMARY=str(summary), **variables)
        elif step["uses"].startswith("actions/upload-artifact@"):
            code = kept(step["with"]["path"].split(), folder)
        failed = failed or code
    return failed


def gitlab(job, folder):
    lines = job.get("before_script", []) + job["script"]
    failed = run("\n".join(lines), folder, ("bash", "-eo", "pipefail"), GITLAB_CI="true", CI_PROJECT_DIR=str(folder))
    return failed or kept(job["artifacts"]["paths"] + [job["artifacts"]["reports"]["junit"]], folder)


def main(path, folder):
    recipe = yaml.safe_load(pathlib.Path(path).read_text(encoding="utf-8"))
    jobs = recipe.get("jobs", recipe)
    (job,) = jobs.values()
    return (github if "jobs" in recipe else gitlab)(job, pathlib.Path(folder).resolve())


sys.exit(main(*sys.argv[1:]))
