"""Shorter bytecode is that of the same shader."""

from measured_brdf.addon.core.shading.compiler import compact

COMPILED = """OpenShadingLanguage 1.00
shader named
param\tfloat\tlength\t0.5\t\t%meta{string,help,"of $tmp1"} %read{1,2} %write{-1,-1}
local\tfloat\t___12_length %read{1,2} %write{1,1}
local\tvector\t___13_frame.x %mystruct{___13_frame} %mystructfield{0}
temp\tfloat\t$tmp1
const\tstring\t$const1\t\t"$tmp1 and ___12_length"
const\tfloat\t$const2\t\t0.123456789
code ___main___
# named.osl:1
\tlength\t\t___12_length ___13_frame.x \t%filename{"named.osl"} %line{1} %argrw{"wr"}
\tadd\t\t$tmp1 ___12_length $const2 %argrw{"wrr"}
\taassign\t\t___13_frame.x $const2 $tmp1 %argrw{"rrr"}
\tend
"""


def test_names_of_variables_are_short_and_those_that_are_seen_stay():
    *lines, end = compact(COMPILED).split("\n")
    assert not end
    assert lines[2] == 'param\tfloat\tlength\t0.5\t\t%meta{string,help,"of $tmp1"}'
    assert lines[3:] == ["local\tfloat\t$0", "local\tvector\t___13_frame.x %mystruct{___13_frame} %mystructfield{0}",
                         "temp\tfloat\t$1", 'const\tstring\t$3\t\t"$tmp1 and ___12_length"',
                         "const\tfloat\t$2\t\t0.123456789", "code ___main___", "\tlength\t\t$0 ___13_frame.x",
                         "\tadd\t\t$1 $0 $2", '\taassign\t\t___13_frame.x $2 $1 %argrw{"rrr"}', "\tend"]


def test_tables_are_rounded_to_single_precision():
    numbers = [(-1) ** n / (n + 1) ** 3 for n in range(200)]
    line = f"const\tfloat[200]\t$const1\t{' '.join(f'{number:.9g}' for number in numbers)} \n"
    rounded = list(map(float, compact(line).split("\t")[3].split()))
    assert max(abs(one / other - 1) for one, other in zip(rounded, numbers, strict=True)) < 5.1e-7
