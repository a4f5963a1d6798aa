"""Work outside of Blender's main thread: in worker processes or in a second Blender; and what operators and panels ask.

`tasks` holds the work itself and `worker` the process that does it; these, `job`, `recent`, `shared` and `discovery` do
not import bpy. `process` starts workers, `queue` and `queries` answer panels, `modal` runs operators, `making` makes
materials of what they return, and `command` is the command line.
"""
