// The walk of passes that write both disks of a contact: those of the cells of one colour at a time, cells that are three
// apart, so that no two invocations touch one disk. Contacts of large disks have a dispatch of their own, of one
// invocation. Calls `meet(k)` for each disk `mine`; `where(i)` is where disk i is looked for. CPU twin:
// disks::cpu::Disks::in_colors.

const uint LARGE_ONES = 0xffffffffu;

void main() {
    if (p.color == LARGE_ONES) {
        if (item() > 0u) return;
        for (mine = 0u; mine < large(); ++mine) visit(mine, where(mine));
        return;
    }
    // The cell of this colour that the invocation has.
    uvec3 of = uvec3(p.color % 3u, p.color / 3u % 3u, p.color / 9u);
    uvec3 n = (p.cells.xyz + 2u - of) / 3u;
    uint at = item();
    if (at >= n.x * n.y * n.z) return;
    uvec3 c = uvec3(at % n.x, at / n.x % n.y, at / n.x / n.y) * 3u + of;
    // Round the cell that they are sorted into, wherever they are pushed meanwhile.
    uint cell = cell_index(ivecd(c));
    uint last = large() + start[cell + 1u];
    for (mine = large() + start[cell]; mine < last; ++mine) visit_cells(mine, ivecd(c));
}
