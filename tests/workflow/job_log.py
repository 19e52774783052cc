"""A Snakemake log handler that writes every planned job as a line of JSON into jobs.jsonl of the working folder."""

import json


def log_handler(message):
    """Called by Snakemake with each log message (a dict)."""
    if message["level"] == "job_info":
        keys = ("name", "input", "output", "log", "benchmark", "reason")
        job = {key: message[key] if isinstance(message[key], list) else str(message[key] or "") for key in keys}
        job["wildcards"] = dict(message["wildcards"])
        with open("jobs.jsonl", "a") as stream:
            stream.write(json.dumps(job) + "\n")
