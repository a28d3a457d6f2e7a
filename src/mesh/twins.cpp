#include "mesh/twins.h"

#include <algorithm>
#include <utility>

#include "relief/mesh/walk.h"

namespace relief::mesh {

namespace {

/// A half-edge among those with the same smaller end.
struct Entry {
    Index key;  ///< 2 x the larger end + 1 if it begins there
    Index half_edge;

    [[nodiscard]] Index larger() const { return key >> 1; }
};

/// Buckets are small: about 6 entries.
void sort_bucket(Entry* first, Entry* last) {
    constexpr std::ptrdiff_t few = 24;
    const auto less = [](const Entry& a, const Entry& b) { return a.key < b.key; };
    if (last - first > few) return std::stable_sort(first, last, less);
    for (Entry* i = first; i != last; ++i)
        for (Entry* j = i; j != first && less(*j, *(j - 1)); --j) std::swap(*j, *(j - 1));
}

void match(const Entry* first, const Entry* last, Buffer<Index>& twin, std::vector<Index>& bad) {
    while (first != last) {
        const Entry* end = first + 1;
        while (end != last && end->larger() == first->larger()) ++end;
        const bool pair = end - first == 2 && first->key != (first + 1)->key;
        if (end - first > 1 && !pair) bad.push_back((first + 1)->half_edge);
        for (const Entry* entry = first; entry != end; ++entry) twin[entry->half_edge] = kNone;
        if (pair) {
            twin[first->half_edge] = (first + 1)->half_edge;
            twin[(first + 1)->half_edge] = first->half_edge;
        }
        first = end;
    }
}

}  // namespace

std::vector<Index> find_twins(Topology& mesh) {
    mesh.twin = Buffer<Index>(mesh.origin.size());
    Buffer<Index> ends(std::size_t{mesh.vertex_count} + 1);
    std::fill_n(ends.data(), ends.size(), Index{0});
    each_half_edge(mesh, [&](Index, Index h, Index next, Index) {
        ++ends[std::min(mesh.origin[h], mesh.origin[next])];
    });
    Index sum = 0;
    for (Index v = 0; v <= mesh.vertex_count; ++v) sum += std::exchange(ends[v], sum);
    Buffer<Entry> entries(mesh.origin.size());
    each_half_edge(mesh, [&](Index, Index h, Index next, Index) {
        const Index a = mesh.origin[h];
        const Index b = mesh.origin[next];
        entries[ends[std::min(a, b)]++] = {2 * std::max(a, b) + (a > b), h};
    });
    std::vector<Index> bad;
    Index begin = 0;
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        Entry* const first = entries.data() + begin;
        Entry* const last = entries.data() + ends[v];
        begin = ends[v];
        sort_bucket(first, last);
        match(first, last, mesh.twin, bad);
    }
    return bad;
}

}  // namespace relief::mesh
