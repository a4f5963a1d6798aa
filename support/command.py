"""The extension's command line in this Blender: a second one takes two seconds to start."""

import io
from contextlib import redirect_stderr, redirect_stdout
from subprocess import CompletedProcess

import bpy

CHEAP = ("--preset", "Paper", "--diffuse-level", "2", "--specular-level", "4", "--compression", "80")       # and good


def run(*arguments):
    """What `blender --command measured_brdf ARGUMENTS` does with no file open: a CompletedProcess."""
    from measured_brdf.addon.work import command

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stdout, stderr = io.StringIO(), io.StringIO()
    with redirect_stdout(stdout), redirect_stderr(stderr):
        code = command.main([str(argument) for argument in arguments])
    return CompletedProcess(arguments, code, stdout.getvalue(), stderr.getvalue())


def convert(source, out, *more):
    """A folder converted to a library by cheap fits."""
    return run("convert", source, "-o", out, *CHEAP, *more)
