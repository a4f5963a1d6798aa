"""Answers for panels: in tests no timer runs that asks workers."""

import time

from measured_brdf.addon.work import queue


def answer_all():
    """Answer every question that panels have asked, at once and in this process."""
    for lane in queue._lanes.values():
        while lane.queue:
            question = lane.queue.pop(0)
            question.job.result, question.job.finished = question.job.function(), time.monotonic()
            queue._keep(question)
