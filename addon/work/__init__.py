"""Work outside of Blender's main thread: in worker processes or in a second Blender; and what operators and panels ask.

`tasks` holds the work itself and `worker` the process that does it, which `process` starts; `queue` and `queries`
answer panels, `modal` runs operators, `making` makes materials of what they return, and `command` is the command line.
"""
