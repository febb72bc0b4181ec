#include "engine/mesh/surface_repair.hpp"

#include "engine/mesh/winding_number.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numeric>
#include <tuple>
#include <utility>

namespace tetfront {

namespace {

using Triangle = std::array<std::int32_t, 3>;

/// An open component is turned outwards when it encloses more than this part of the volume that a sphere of its area
/// would: below, it is rather a sheet, and either side is right.
constexpr double clearly_encloses = 0.05;

void weld(SurfaceMesh& surface, SurfaceRepairs& repairs) {
    const auto& x = surface.positions;
    std::vector<std::int32_t> order(x.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](std::int32_t v) {
        const Vec3& p = x[static_cast<std::size_t>(v)];
        return std::tuple(p[0], p[1], p[2]);
    };
    std::sort(order.begin(), order.end(),
              [&](std::int32_t a, std::int32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); });
    std::vector<std::int32_t> first(x.size());  // the first vertex at the same position
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
        first[static_cast<std::size_t>(order[i])] = same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
        repairs.welded_vertices += same ? 1 : 0;
    }
    for (Triangle& t : surface.triangles)
        for (std::int32_t& v : t) v = first[static_cast<std::size_t>(v)];
}

void drop_degenerate(SurfaceMesh& surface, SurfaceRepairs& repairs) {
    repairs.degenerate_triangles = std::erase_if(
        surface.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
}

/// A triangle by its vertices, smallest first, and which way it runs around them.
struct TriangleKey {
    Triangle sorted;
    bool even;
    std::size_t triangle;
};

/// Of triangles with the same vertices and orientation one stays. Those with both orientations are kept as a pair (two
/// bodies that touch), unless most of the file comes in such pairs: then it is a two-sided surface and one side goes.
void drop_duplicates(SurfaceMesh& surface, SurfaceRepairs& repairs) {
    std::vector<TriangleKey> keys;
    for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
        Triangle t = surface.triangles[i];
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        const bool even = t[1] < t[2];
        if (!even) std::swap(t[1], t[2]);
        keys.push_back({t, even, i});
    }
    std::sort(keys.begin(), keys.end(), [](const TriangleKey& a, const TriangleKey& b) {
        return std::tie(a.sorted, a.triangle) < std::tie(b.sorted, b.triangle);
    });
    std::vector<char> drop(surface.triangles.size(), 0);
    std::vector<std::size_t> second_sides;
    std::size_t distinct = 0;
    for (std::size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
        ++distinct;
        bool seen[2] = {false, false};
        for (; end < keys.size() && keys[end].sorted == keys[begin].sorted; ++end) {
            bool& side = seen[keys[end].even ? 1 : 0];
            if (side)
                drop[keys[end].triangle] = 1;
            else if (end > begin)
                second_sides.push_back(keys[end].triangle);
            side = true;
        }
    }
    if (2 * second_sides.size() > distinct)
        for (std::size_t t : second_sides) drop[t] = 1;
    repairs.duplicate_triangles = static_cast<std::size_t>(std::ranges::count(drop, 1));
    std::size_t kept = 0;
    for (std::size_t i = 0; i < drop.size(); ++i)
        if (!drop[i]) surface.triangles[kept++] = surface.triangles[i];
    surface.triangles.resize(kept);
}

void drop_unused(SurfaceMesh& surface, SurfaceRepairs& repairs) {
    std::vector<std::int32_t> compact(surface.positions.size(), -1);
    for (const Triangle& t : surface.triangles)
        for (std::int32_t v : t) compact[static_cast<std::size_t>(v)] = 0;
    std::int32_t count = 0;
    for (std::size_t v = 0; v < compact.size(); ++v) {
        if (compact[v] < 0) continue;
        surface.positions[static_cast<std::size_t>(count)] = Vec3(surface.positions[v]);
        compact[v] = count++;
    }
    repairs.unused_vertices = surface.positions.size() - static_cast<std::size_t>(count) - repairs.welded_vertices;
    surface.positions.resize(static_cast<std::size_t>(count));
    for (Triangle& t : surface.triangles)
        for (std::int32_t& v : t) v = compact[static_cast<std::size_t>(v)];
}

/// One side of a triangle, comparable by its ends.
struct Side {
    std::int32_t low, high;
    bool ascending;  // the triangle runs from low to high
    std::int32_t triangle;
};

std::vector<Side> sorted_sides(const SurfaceMesh& surface) {
    std::vector<Side> sides;
    sides.reserve(3 * surface.triangles.size());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int32_t a = surface.triangles[t][i], b = surface.triangles[t][(i + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), a < b, static_cast<std::int32_t>(t)});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });
    return sides;
}

struct Component {
    std::vector<std::int32_t> triangles;
    bool closed = true;
    double volume = 0, area = 0;  // signed volume, seen from the area-weighted middle
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
};

class Orienter {
 public:
    Orienter(SurfaceMesh& surface, SurfaceRepairs& repairs)
        : surface_(surface), repairs_(repairs), flip_(surface.triangles.size(), 0) {
        connect();
        make_neighbours_agree();
        for (Component& c : components_) measure(c);
        face_outwards();
        for (std::size_t t = 0; t < flip_.size(); ++t) {
            if (!flip_[t]) continue;
            std::swap(surface_.triangles[t][1], surface_.triangles[t][2]);
            ++repairs_.flipped_triangles;
        }
        repairs_.components = components_.size();
    }

 private:
    void connect() {
        const std::vector<Side> sides = sorted_sides(surface_);
        neighbours_.assign(surface_.triangles.size(), {});
        open_.assign(surface_.triangles.size(), 0);
        for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
            while (end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high)
                ++end;
            if (end - begin == 1) {
                ++repairs_.open_edges;
                open_[static_cast<std::size_t>(sides[begin].triangle)] = 1;
            } else if (end - begin > 2) {
                ++repairs_.nonmanifold_edges;
            } else {
                const Side &a = sides[begin], &b = sides[begin + 1];
                const bool agree = a.ascending != b.ascending;
                neighbours_[static_cast<std::size_t>(a.triangle)].push_back({b.triangle, agree});
                neighbours_[static_cast<std::size_t>(b.triangle)].push_back({a.triangle, agree});
            }
        }
    }

    /// Walks over each component; the orientation that turns fewer triangles wins. A Moebius strip gets a seam.
    void make_neighbours_agree() {
        std::vector<char> reached(surface_.triangles.size(), 0);
        for (std::size_t seed = 0; seed < reached.size(); ++seed) {
            if (reached[seed]) continue;
            Component component;
            component.triangles.push_back(static_cast<std::int32_t>(seed));
            reached[seed] = 1;
            std::size_t flipped = 0;
            for (std::size_t i = 0; i < component.triangles.size(); ++i) {
                const auto t = static_cast<std::size_t>(component.triangles[i]);
                flipped += flip_[t] ? 1 : 0;
                for (const auto& [next, agree] : neighbours_[t]) {
                    const auto n = static_cast<std::size_t>(next);
                    if (reached[n]) continue;
                    reached[n] = 1;
                    flip_[n] = agree ? flip_[t] : !flip_[t];
                    component.triangles.push_back(next);
                }
            }
            if (2 * flipped > component.triangles.size()) turn(component);
            components_.push_back(std::move(component));
        }
    }

    void turn(const Component& component) {
        for (std::int32_t t : component.triangles) flip_[static_cast<std::size_t>(t)] ^= 1;
    }

    [[nodiscard]] std::array<Vec3, 3> corners(std::int32_t triangle) const {
        const Triangle& t = surface_.triangles[static_cast<std::size_t>(triangle)];
        std::array<Vec3, 3> x;
        for (std::size_t i = 0; i < 3; ++i) x[i] = surface_.positions[static_cast<std::size_t>(t[i])];
        if (flip_[static_cast<std::size_t>(triangle)]) std::swap(x[1], x[2]);
        return x;
    }

    void measure(Component& c) const {
        Vec3 middle = Vec3::Zero();
        c.low.setConstant(std::numeric_limits<double>::infinity());
        c.high = -c.low;
        for (std::int32_t t : c.triangles) {
            const auto x = corners(t);
            const double area = (x[1] - x[0]).cross(x[2] - x[0]).norm() / 2;
            middle += area * (x[0] + x[1] + x[2]) / 3;
            c.area += area;
            for (const Vec3& p : x) {
                c.low = c.low.cwiseMin(p);
                c.high = c.high.cwiseMax(p);
            }
            if (open_[static_cast<std::size_t>(t)]) c.closed = false;
        }
        if (c.area > 0) middle /= c.area;
        for (std::int32_t t : c.triangles) {
            const auto x = corners(t);
            c.volume += signed_volume(middle, x[0], x[1], x[2]);
        }
    }

    void face_outwards() {
        std::vector<std::size_t> by_volume(components_.size());
        std::iota(by_volume.begin(), by_volume.end(), std::size_t{0});
        std::stable_sort(by_volume.begin(), by_volume.end(), [&](std::size_t a, std::size_t b) {
            return std::abs(components_[a].volume) > std::abs(components_[b].volume);
        });
        // From the largest: whoever encloses a component has been decided before it.
        std::vector<std::size_t> outer;
        std::vector<std::unique_ptr<SurfaceBvh>> hierarchy(components_.size());
        std::vector<char> turned(components_.size(), 0);
        for (std::size_t c : by_volume) {
            Component& component = components_[c];
            const double sphere = std::pow(component.area, 1.5) / 10.6;  // volume of a sphere of this area
            if (!component.closed && std::abs(component.volume) < clearly_encloses * sphere) continue;
            std::size_t container = components_.size();
            const Vec3 witness = corners(component.triangles[0])[0];
            for (std::size_t o : outer) {
                const Component& other = components_[o];
                if ((component.low.array() < other.low.array()).any() ||
                    (component.high.array() > other.high.array()).any())
                    continue;
                if (!hierarchy[o]) hierarchy[o] = std::make_unique<SurfaceBvh>(extract(other));
                if (std::abs(hierarchy[o]->winding_number(witness)) < 0.5) continue;
                container = o;
                break;
            }
            const bool nested = container < components_.size();
            turned[c] = nested ? turned[container] : component.volume < 0;
            if (turned[c]) turn(component);
            if (!nested && component.closed) outer.push_back(c);
        }
    }

    [[nodiscard]] SurfaceMesh extract(const Component& component) const {
        SurfaceMesh mesh;
        for (std::int32_t t : component.triangles) {
            const auto first = static_cast<std::int32_t>(mesh.positions.size());
            for (const Vec3& x : corners(t)) mesh.positions.push_back(x);
            mesh.triangles.push_back({first, first + 1, first + 2});
        }
        return mesh;
    }

    SurfaceMesh& surface_;
    SurfaceRepairs& repairs_;
    std::vector<char> flip_;                                              // [F] turn the triangle around
    std::vector<char> open_;                                              // [F] has an edge of its own
    std::vector<std::vector<std::pair<std::int32_t, bool>>> neighbours_;  // [F] over edges of two; agrees as it is
    std::vector<Component> components_;
};

}  // namespace

SurfaceRepairs repair(SurfaceMesh& surface) {
    SurfaceRepairs repairs;
    weld(surface, repairs);
    drop_degenerate(surface, repairs);
    drop_duplicates(surface, repairs);
    drop_unused(surface, repairs);
    Orienter(surface, repairs);
    return repairs;
}

std::string describe(const SurfaceRepairs& r) {
    std::string text;  // welded vertices are no news: most formats store them once for each triangle
    const auto say = [&](std::size_t count, const char* what) {
        if (count) text += std::to_string(count) + " " + what + "\n";
    };
    say(r.parts > 1 ? r.parts : 0, "parts merged");
    say(r.unused_vertices, "unused vertices dropped");
    say(r.degenerate_triangles, "degenerate triangles dropped");
    say(r.duplicate_triangles, "duplicate triangles dropped");
    say(r.flipped_triangles, "triangles turned around");
    say(r.open_edges, "open edges (the surface has holes)");
    say(r.nonmanifold_edges, "edges with more than two triangles");
    return text;
}

}  // namespace tetfront
