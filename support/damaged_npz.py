"""Saved arrays with a damaged header."""

import io
import zipfile


def with_header(content, change):
    """An .npz file whose first array has another header, of the same length: sizes and checksums are right."""
    changed = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as file, zipfile.ZipFile(changed, "w", zipfile.ZIP_DEFLATED) as other:
        for number, member in enumerate(file.infolist()):
            data = file.read(member)
            length = int.from_bytes(data[8:10], "little")
            if not number:
                data = data[:10] + change(data[10:10 + length]) + data[10 + length:]
            other.writestr(member.filename, data)
    return changed.getvalue()
