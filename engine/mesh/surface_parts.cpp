#include "engine/mesh/surface_parts.hpp"

#include "engine/base/disjoint_sets.hpp"

#include <algorithm>

namespace tetfront {

SurfaceParts surface_parts(const SurfaceMesh& surface) {
    struct Edge {
        std::int32_t low, high, triangle;
        auto operator<=>(const Edge&) const = default;
    };
    std::vector<Edge> edges;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [low, high] = std::minmax(surface.triangles[t][i], surface.triangles[t][(i + 1) % 3]);
            edges.push_back({low, high, static_cast<std::int32_t>(t)});
        }
    std::ranges::sort(edges);
    DisjointSets sets(surface.triangles.size());
    for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
        while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
        if (end - i == 2) sets.join(static_cast<std::size_t>(edges[i].triangle), static_cast<std::size_t>(edges[i + 1].triangle));
    }
    std::vector<std::int32_t> part(surface.triangles.size());
    std::int32_t count = 0;
    for (std::size_t t = 0; t < part.size(); ++t) part[t] = sets.find(t) == t ? count++ : part[sets.find(t)];
    return {std::move(part), static_cast<std::size_t>(count)};
}

}  // namespace tetfront
