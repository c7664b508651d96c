"""The loops over faces and cells, compiled by numba: fused they are some ten times NumPy's speed.

1. Formulas are those of OpenFOAM's primitiveMeshFaceCentresAndAreas,
   primitiveMeshCellCentresAndVols, primitiveMeshTools (v1912) in the order of its sums, so that
   figures agree with checkMesh to rounding. `orthogonal quality` is that of Fluent's guide.
2. Faces are polygons with normals from owner to neighbour (-1: none). In a plane a face is an
   edge of unit depth: the same as OpenFOAM's one layer of cells between `empty` planes.
3. Each kernel fills the entries of the faces or cells it is given, without the GIL, so that
   several threads share the work.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.meshes.measures.work import compiled

VERY_SMALL = 1.0e-300  # VSMALL
ROOT_VERY_SMALL = 1.0e-150  # ROOTVSMALL


@compiled
def faces_between(
    chosen: np.ndarray,
    owner: np.ndarray,
    neighbour: np.ndarray,
    moved: np.ndarray,
    faces: np.ndarray,
    around: np.ndarray,
) -> None:
    """Flag those of the chosen faces that bound a moved cell, and the cells on both sides."""
    for f in chosen:
        o, n = owner[f], neighbour[f]
        if moved[o] or (n >= 0 and moved[n]):
            faces[f] = True
            around[o] = True
            if n >= 0:
                around[n] = True


@compiled
def face_geometry(
    chosen: np.ndarray,
    points: np.ndarray,
    nodes: np.ndarray,
    offsets: np.ndarray,
    geometry: np.ndarray,
) -> None:
    """Area vector, centre, least and largest cosine of an angle (-2: reflex) of chosen faces."""
    for f in chosen:
        begin, end = offsets[f], offsets[f + 1]
        size = end - begin
        p, a = nodes[end - 2], nodes[end - 1]
        ax, ay, az = points[a, 0], points[a, 1], points[a, 2]
        if size == 2:
            geometry[f, 0], geometry[f, 1] = ay - points[p, 1], points[p, 0] - ax
            for k in range(3):
                geometry[f, 3 + k] = (points[a, k] + points[p, k]) / 2
            continue
        mx, my, mz = 0.0, 0.0, 0.0
        for i in range(begin, end):
            mx += points[nodes[i], 0]
            my += points[nodes[i], 1]
            mz += points[nodes[i], 2]
        mx, my, mz = mx / size, my / size, mz / size
        sx, sy, sz, total, cx, cy, cz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        tx, ty, tz = ax - points[p, 0], ay - points[p, 1], az - points[p, 2]
        before = 1.0 / np.sqrt(tx * tx + ty * ty + tz * tz)
        least, most, reflex = 1.0, -1.0, False
        for i in range(begin, end):
            b = nodes[i]
            bx, by, bz = points[b, 0], points[b, 1], points[b, 2]
            ux, uy, uz = bx - ax, by - ay, bz - az
            vx, vy, vz = mx - ax, my - ay, mz - az
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            size_n = np.sqrt(nx * nx + ny * ny + nz * nz)
            sx, sy, sz, total = sx + nx, sy + ny, sz + nz, total + size_n
            cx += size_n * (ax + bx + mx)
            cy += size_n * (ay + by + my)
            cz += size_n * (az + bz + mz)
            here = 1.0 / np.sqrt(ux * ux + uy * uy + uz * uz)
            cosine = -(tx * ux + ty * uy + tz * uz) * before * here
            reflex = reflex or here == np.inf  # an edge without length
            least, most = min(least, cosine), max(most, cosine)
            ax, ay, az, tx, ty, tz, before = bx, by, bz, ux, uy, uz, here
        geometry[f, 0], geometry[f, 1], geometry[f, 2] = sx / 2, sy / 2, sz / 2
        if total < ROOT_VERY_SMALL or size == 3:
            geometry[f, 3], geometry[f, 4], geometry[f, 5] = mx, my, mz
        else:
            third = 1.0 / (3.0 * total)
            geometry[f, 3], geometry[f, 4], geometry[f, 5] = cx * third, cy * third, cz * third
        if size > 3 and total * total > 1.0000001 * (sx * sx + sy * sy + sz * sz):
            p, a = nodes[end - 2], nodes[end - 1]  # not flat or not convex: look at each turn
            tx = points[a, 0] - points[p, 0]
            ty = points[a, 1] - points[p, 1]
            tz = points[a, 2] - points[p, 2]
            for i in range(begin, end):
                b = nodes[i]
                ux = points[b, 0] - points[a, 0]
                uy = points[b, 1] - points[a, 1]
                uz = points[b, 2] - points[a, 2]
                turn = (
                    (ty * uz - tz * uy) * sx + (tz * ux - tx * uz) * sy + (tx * uy - ty * ux) * sz
                )
                reflex = reflex or turn < 0.0
                a, tx, ty, tz = b, ux, uy, uz
        geometry[f, 6], geometry[f, 7] = -2.0 if reflex else least, most


@compiled
def cell_geometry(
    chosen: np.ndarray,
    cell_offsets: np.ndarray,
    cell_faces: np.ndarray,
    owner: np.ndarray,
    geometry: np.ndarray,
    directions: np.ndarray,
    flat: bool,
    volumes: np.ndarray,
    middles: np.ndarray,
    aspects: np.ndarray,
) -> None:
    """Volumes, centres and aspect ratios of the chosen cells.

    `directions` flags the axes that count for the aspect ratio (not those across `empty`).
    """
    near, share = (2.0 / 3.0, 1.0 / 2.0) if flat else (0.75, 1.0 / 3.0)
    for c in chosen:
        begin, end = cell_offsets[c], cell_offsets[c + 1]
        ex, ey, ez = 0.0, 0.0, 0.0
        for i in range(begin, end):
            f = cell_faces[i]
            ex, ey, ez = ex + geometry[f, 3], ey + geometry[f, 4], ez + geometry[f, 5]
        count = end - begin
        ex, ey, ez = ex / count, ey / count, ez / count
        volume, x, y, z, px, py, pz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(begin, end):
            f = cell_faces[i]
            ax, ay, az = geometry[f, 0], geometry[f, 1], geometry[f, 2]
            fx, fy, fz = geometry[f, 3], geometry[f, 4], geometry[f, 5]
            pyramid = ax * (fx - ex) + ay * (fy - ey) + az * (fz - ez)
            if owner[f] != c:
                pyramid = -pyramid
            volume += pyramid
            x += pyramid * (near * fx + (1 - near) * ex)
            y += pyramid * (near * fy + (1 - near) * ey)
            z += pyramid * (near * fz + (1 - near) * ez)
            px, py, pz = px + abs(ax), py + abs(ay), pz + abs(az)
        if abs(volume) > VERY_SMALL:
            middles[c, 0], middles[c, 1], middles[c, 2] = x / volume, y / volume, z / volume
        else:
            middles[c, 0], middles[c, 1], middles[c, 2] = ex, ey, ez
        volume *= share
        volumes[c] = volume
        low, high = np.inf, 0.0
        if directions[0]:
            low, high = min(low, px), max(high, px)
        if directions[1]:
            low, high = min(low, py), max(high, py)
        if directions[2]:
            low, high = min(low, pz), max(high, pz)
        aspect = high / (low + ROOT_VERY_SMALL)
        if directions.all():
            full = max(ROOT_VERY_SMALL, volume)
            aspect = max(aspect, (px + py + pz) / 6 / full ** (2.0 / 3.0))
        aspects[c] = aspect


@compiled
def face_measures(
    chosen: np.ndarray,
    points: np.ndarray,
    nodes: np.ndarray,
    offsets: np.ndarray,
    owner: np.ndarray,
    neighbour: np.ndarray,
    geometry: np.ndarray,
    volumes: np.ndarray,
    middles: np.ndarray,
    measures: np.ndarray,
) -> None:
    """Fill rows of seven for the chosen faces.

    They are: cosine of non-orthogonality, skewness, orthogonal quality from the owner and from
    the neighbour, growth, and the two cosines of the geometry. A face without area (of a
    collapsed cell) is as good as none.
    """
    for f in chosen:
        o, n = owner[f], neighbour[f]
        ax, ay, az = geometry[f, 0], geometry[f, 1], geometry[f, 2]
        size = np.sqrt(ax * ax + ay * ay + az * az)
        cx = geometry[f, 3] - middles[o, 0]
        cy = geometry[f, 4] - middles[o, 1]
        cz = geometry[f, 5] - middles[o, 2]
        reach = ax * cx + ay * cy + az * cz
        ratio = reach / (size * np.sqrt(cx * cx + cy * cy + cz * cz) + VERY_SMALL)
        if n >= 0:
            dx = middles[n, 0] - middles[o, 0]
            dy = middles[n, 1] - middles[o, 1]
            dz = middles[n, 2] - middles[o, 2]
            along = ax * dx + ay * dy + az * dz
            distance = np.sqrt(dx * dx + dy * dy + dz * dz)
            cosine = along / (distance * size + ROOT_VERY_SMALL)
            ex, ey, ez = cx - dx, cy - dy, cz - dz
            back = -(ax * ex + ay * ey + az * ez)
            far = back / (size * np.sqrt(ex * ex + ey * ey + ez * ez) + VERY_SMALL)
            ratio, far = min(ratio, cosine), min(far, cosine)
            large, small = max(volumes[o], volumes[n]), min(volumes[o], volumes[n])
            growth = large / small if small > 0 else np.inf
            reference = 0.2 * distance + ROOT_VERY_SMALL
        else:
            cosine, far, growth = 1.0, 1.0, 1.0
            inverse = 1.0 / (size + ROOT_VERY_SMALL)
            height = reach * inverse
            dx, dy, dz = ax * inverse * height, ay * inverse * height, az * inverse * height
            along = ax * dx + ay * dy + az * dz
            reference = 0.4 * np.sqrt(dx * dx + dy * dy + dz * dz) + ROOT_VERY_SMALL
        measures[f, 5], measures[f, 6] = geometry[f, 6], geometry[f, 7]
        if size < ROOT_VERY_SMALL:
            measures[f, 0], measures[f, 1], measures[f, 2] = 1.0, 0.0, 1.0
            measures[f, 3], measures[f, 4] = 1.0, growth
            continue
        part = reach / (along + ROOT_VERY_SMALL)
        sx, sy, sz = cx - part * dx, cy - part * dy, cz - part * dz
        skew = np.sqrt(sx * sx + sy * sy + sz * sz)
        inverse = 1.0 / (skew + ROOT_VERY_SMALL)
        sx, sy, sz = sx * inverse, sy * inverse, sz * inverse
        for i in range(offsets[f], offsets[f + 1]):
            p = nodes[i]
            away = (
                sx * (points[p, 0] - geometry[f, 3])
                + sy * (points[p, 1] - geometry[f, 4])
                + sz * (points[p, 2] - geometry[f, 5])
            )
            reference = max(reference, abs(away))
        measures[f, 0], measures[f, 1], measures[f, 2] = cosine, skew / reference, ratio
        measures[f, 3], measures[f, 4] = far, growth


@compiled
def worst_of_faces(
    chosen: np.ndarray,
    cell_offsets: np.ndarray,
    cell_faces: np.ndarray,
    owner: np.ndarray,
    offsets: np.ndarray,
    measures: np.ndarray,
    out: np.ndarray,
) -> None:
    """Worst values of the faces of each chosen cell.

    Five rows: non-orthogonality in degrees, skewness, orthogonal quality, growth, equiangle
    skewness. Angles are compared by their cosines as long as the faces have the same size.
    """
    for c in chosen:
        cosine, skew, quality, growth, angle = 1.0, 0.0, 1.0, 1.0, 0.0
        begin, end = cell_offsets[c], cell_offsets[c + 1]
        least, most, size = 1.0, -1.0, 0
        for i in range(begin, end + 1):
            f = cell_faces[min(i, end - 1)]
            new = offsets[f + 1] - offsets[f] if i < end else 0
            if new != size:
                if size > 2:
                    ideal = np.pi * (size - 2) / size
                    large = (np.arccos(max(least, -1.0)) - ideal) / (np.pi - ideal)
                    small = (ideal - np.arccos(min(most, 1.0))) / ideal
                    angle = max(angle, max(large, small))
                least, most, size = 1.0, -1.0, new
            cosine = min(cosine, measures[f, 0])
            skew = max(skew, measures[f, 1])
            quality = min(quality, measures[f, 2 if owner[f] == c else 3])
            growth = max(growth, measures[f, 4])
            least, most = min(least, measures[f, 5]), max(most, measures[f, 6])
            if measures[f, 5] < -1.1:
                angle = 1.0
        out[0, c] = np.degrees(np.arccos(min(max(cosine, -1.0), 1.0)))
        out[1, c], out[2, c], out[3, c], out[4, c] = skew, quality, growth, min(angle, 1.0)
