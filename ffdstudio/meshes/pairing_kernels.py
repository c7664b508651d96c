"""Compiled loops that find equal faces: buckets by the smallest node of a face.

1. A face lies in the bucket of its smallest node. Its next two nodes in ascending order make
   one number of 64 bits; the largest one of a quad stands in an array of its own, with -1 for
   triangles beside quads.
2. A node has some ten faces, so all pairs of a bucket are compared; larger buckets (a pole, a
   hostile file) are sorted first.
3. Each thread takes a share of the cells and its own places in every bucket. What ends up where
   depends on the number of threads, what is equal to what does not.
"""

from __future__ import annotations

import numpy as np

from ffdstudio.aliases import AnyArray
from ffdstudio.compiling import compiled

ALONE, FIRST, SECOND, MANY = 0, 1, 2, 3
Key = tuple[np.signedinteger, ...]
FEW = 64  # faces in a bucket whose pairs are all compared


@compiled
def smallest(nodes: AnyArray, table: AnyArray, row: int, face: int) -> int:
    """Least node of one face of one cell; triangles repeat their last corner."""
    least = min(nodes[row, table[face, 0]], nodes[row, table[face, 1]])
    other = min(nodes[row, table[face, 2]], nodes[row, table[face, 3]])
    return int(min(least, other))


@compiled
def key_of(nodes: AnyArray, table: AnyArray, row: int, face: int) -> Key:
    """Smallest node, the next two as one number, and the largest one of a quad or -1."""
    a, b = np.int64(nodes[row, table[face, 0]]), np.int64(nodes[row, table[face, 1]])
    c, d = np.int64(nodes[row, table[face, 2]]), np.int64(nodes[row, table[face, 3]])
    if table[face, 2] == table[face, 3]:
        low, high = min(a, b), max(a, b)
        least, most = min(low, c), max(high, c)
        if table[face, 1] == table[face, 2]:  # an edge
            return least, most, np.int64(-1)
        return least, ((a + b + c - least - most) << 32) | most, np.int64(-1)
    p, q, r, s = min(a, b), max(a, b), min(c, d), max(c, d)
    least, most = min(p, r), max(q, s)
    t, u = max(p, r), min(q, s)
    return least, (min(t, u) << 32) | max(t, u), most


@compiled
def counted(begin: int, end: int, nodes: AnyArray, table: AnyArray, count: AnyArray) -> None:
    """Add the faces of rows begin to end to ``count[n]``, n their smallest node."""
    for row in range(begin, end):
        for face in range(len(table)):
            count[smallest(nodes, table, row, face)] += 1


@compiled
def filled(
    begin: int,
    end: int,
    nodes: AnyArray,
    table: AnyArray,
    start: int,
    at: AnyArray,
    keys: AnyArray,
    extra: AnyArray,
    ids: AnyArray,
) -> None:
    """Put the faces of rows begin to end into their buckets; ``at[n]`` is where the next goes.

    `extra` may be empty without quads. `ids`, unless empty, gets the number of each face: from
    `start` on, face by face of the table, all rows in each.
    """
    quads, numbers = len(extra) > 0, len(ids) > 0
    for row in range(begin, end):
        for face in range(len(table)):
            least, key, most = key_of(nodes, table, row, face)
            place = at[least]
            at[least] = place + 1
            keys[place] = key
            if quads:
                extra[place] = most
            if numbers:
                ids[place] = start + face * len(nodes) + row


@compiled
def before(key: int, most: int, i: int, keys: AnyArray, extra: AnyArray) -> bool:
    """Whether a face comes before the one at place i."""
    if key != keys[i] or len(extra) == 0:
        return bool(key < keys[i])
    return bool(most < extra[i])


@compiled
def ordered(begin: int, end: int, keys: AnyArray, extra: AnyArray, ids: AnyArray) -> None:
    """Sort the faces of a large bucket (Shell's method)."""
    gap = 1
    while 3 * gap + 1 < end - begin:
        gap = 3 * gap + 1
    while gap > 0:
        for i in range(begin + gap, end):
            key, most = keys[i], extra[i] if len(extra) > 0 else 0
            number = ids[i] if len(ids) > 0 else 0
            j = i
            while j >= begin + gap and before(key, most, j - gap, keys, extra):
                keys[j] = keys[j - gap]
                if len(extra) > 0:
                    extra[j] = extra[j - gap]
                if len(ids) > 0:
                    ids[j] = ids[j - gap]
                j -= gap
            keys[j] = key
            if len(extra) > 0:
                extra[j] = most
            if len(ids) > 0:
                ids[j] = number
        gap //= 3


@compiled
def matched(
    low: int,
    high: int,
    first: AnyArray,
    keys: AnyArray,
    extra: AnyArray,
    ids: AnyArray,
    state: AnyArray,
    partner: AnyArray,
    names: AnyArray,
) -> None:
    """Set `state` in the buckets low to high: alone, first and second of a pair, or one of many.

    `partner`, unless empty, gets the partner of each face by number, or ``names[0]`` where it is
    alone and ``names[1]`` where it is one of many.
    """
    quads, numbers = len(extra) > 0, len(partner) > 0
    for node in range(low, high):
        begin, end = first[node], first[node + 1]
        sort = end - begin > FEW
        if sort:
            ordered(begin, end, keys, extra, ids)
        for i in range(begin, end):
            state[i] = ALONE
        for i in range(begin, end):
            if state[i] != ALONE:
                continue
            key, other, found = keys[i], -1, 0
            for j in range(i + 1, end):
                if keys[j] == key:
                    if not quads or extra[j] == extra[i]:
                        other, found = j, found + 1
                        state[j] = SECOND
                elif sort:
                    break
            if found == 1:
                state[i] = FIRST
                if numbers:
                    partner[ids[i]], partner[ids[other]] = ids[other], ids[i]
            elif found == 0:
                if numbers:
                    partner[ids[i]] = names[0]
            else:
                for j in range(i, end):
                    if keys[j] == key and (not quads or extra[j] == extra[i]):
                        state[j] = MANY
                        if numbers:
                            partner[ids[j]] = names[1]


@compiled
def marked(low: int, high: int, first: AnyArray, state: AnyArray, has: AnyArray) -> None:
    """Set ``has[n]`` for the nodes whose bucket has a face that is alone."""
    for node in range(low, high):
        for i in range(first[node], first[node + 1]):
            if state[i] == ALONE:
                has[node] = 1
                break


@compiled
def alone(
    begin: int,
    end: int,
    nodes: AnyArray,
    table: AnyArray,
    face: int,
    first: AnyArray,
    keys: AnyArray,
    extra: AnyArray,
    state: AnyArray,
    has: AnyArray,
    out: AnyArray,
) -> int:
    """Rows begin to end whose face is alone, written to `out`; how many."""
    count = 0
    for row in range(begin, end):
        if has[smallest(nodes, table, row, face)] == 0:
            continue
        least, key, most = key_of(nodes, table, row, face)
        low, high = first[least], first[least + 1]
        if high - low > FEW:
            while low < high:
                middle = (low + high) // 2
                if before(key, most, middle, keys, extra):
                    high = middle
                else:
                    low = middle + 1
            low, high = max(low - 1, first[least]), low
        for i in range(low, high):
            if state[i] == ALONE and keys[i] == key and (len(extra) == 0 or extra[i] == most):
                out[count] = row
                count += 1
                break
    return count


@compiled
def emitted(
    nodes: AnyArray,
    corners: AnyArray,
    of_cell: AnyArray,
    start: int,
    partner: AnyArray,
    cells: AnyArray,
    out: AnyArray,
    owner: AnyArray,
    neighbour: AnyArray,
) -> None:
    """Write each face that is alone, or the first of a pair, with the cells on both sides.

    `corners` are those of one face in `nodes`, `of_cell` the cell of each row; ``start`` is the
    number of the first of these faces, and `cells` tells the cell of a face by number.
    """
    at = 0
    for row in range(len(nodes)):
        other = partner[start + row]
        if other >= 0 and other < start + row:
            continue
        for j in range(len(corners)):
            out[at, j] = nodes[row, corners[j]]
        owner[at] = of_cell[row]
        neighbour[at] = cells[other] if other >= 0 else -1
        at += 1


@compiled
def looped(nodes: AnyArray, offsets: AnyArray, numbers: AnyArray, total: AnyArray) -> None:
    """Sum of the numbers of the nodes of faces of any size, whatever their order."""
    for face in range(len(offsets) - 1):
        add = numbers[0] - numbers[0]
        for i in range(offsets[face], offsets[face + 1]):
            add += numbers[nodes[i]]
        total[face] = add


@compiled
def loops_matched(
    order: AnyArray,
    nodes: AnyArray,
    offsets: AnyArray,
    total: AnyArray,
    partner: AnyArray,
    names: AnyArray,
) -> None:
    """Partners of faces of any size, `order` listing them by the sum that equal ones have."""
    for i in range(len(order)):
        f = order[i]
        for k in range(i + 1, len(order)):
            g = order[k]
            size = offsets[f + 1] - offsets[f]
            if total[f] != total[g]:
                break
            same = size == offsets[g + 1] - offsets[g]
            for a in range(offsets[f], offsets[f + 1]):
                has = False
                for b in range(offsets[g], offsets[g + 1]):
                    has = has or nodes[a] == nodes[b]
                same = same and has
            if not same:
                continue
            if partner[f] == names[0] and partner[g] == names[0]:
                partner[f], partner[g] = g, f
            else:
                for h in (f, g):
                    if partner[h] >= 0:
                        partner[partner[h]] = names[1]
                    partner[h] = names[1]
