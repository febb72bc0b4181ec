#include "engine/mesh/isosurface_stuffing.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <unordered_map>
#include <utility>

namespace tetfront {

namespace {

/// A vertex is warped when a cut point is closer than this part of the edge ([Labelle] table 2, safe for all shapes).
/// Long edges join two corners or two centres of cubes, short ones a corner and a centre.
constexpr double warp_long = 0.24999, warp_short = 0.41189;
/// Halvings of an edge to find where it crosses the boundary: to 2e-5 of its length.
constexpr int bisections = 16;
constexpr double max_cells = 1 << 26;

using Int3 = std::array<int, 3>;
/// Lattice point. Its coordinates in half cells are all even (corner of a cube) or all odd (centre of a cube).
using PointId = std::int64_t;

class Lattice {
 public:
    Lattice(const Vec3& low, const Vec3& high, double cell) : cell_(cell) {
        double cells = 1;
        for (int i = 0; i < 3; ++i) cells *= std::ceil((high[i] - low[i]) / cell) + 4;
        if (!(cells <= max_cells)) {
            std::ostringstream problem;
            problem << "cells of " << cell << " m cut its bounding box into " << cells << " cubes";
            throw InputError{"", "volume mesh", problem.str(),
                             "use larger cells (fewer tets) or a less scattered surface"};
        }
        for (int i = 0; i < 3; ++i) {
            // One layer of cubes around the box, and one to spare, so that nothing touches the lattice's border.
            const auto k = static_cast<std::size_t>(i);
            cubes_[k] = static_cast<int>(std::ceil((high[i] - low[i]) / cell)) + 4;
            origin_[i] = (low[i] + high[i]) / 2 - cell * cubes_[k] / 2;
        }
        corner_count_ = PointId{cubes_[0] + 1} * (cubes_[1] + 1) * (cubes_[2] + 1);
    }
    [[nodiscard]] PointId size() const { return corner_count_ + PointId{cubes_[0]} * cubes_[1] * cubes_[2]; }
    [[nodiscard]] const Int3& cubes() const { return cubes_; }
    [[nodiscard]] PointId id(const Int3& half) const {
        const int odd = half[0] & 1;
        const int nx = cubes_[0] + 1 - odd, ny = cubes_[1] + 1 - odd;
        return (odd ? corner_count_ : 0) + half[0] / 2 + PointId{nx} * (half[1] / 2 + PointId{ny} * (half[2] / 2));
    }
    /// Coordinates in half cells.
    [[nodiscard]] Int3 half(PointId p) const {
        const int odd = p >= corner_count_ ? 1 : 0;
        const PointId nx = cubes_[0] + 1 - odd, ny = cubes_[1] + 1 - odd;
        if (odd) p -= corner_count_;
        return {static_cast<int>(2 * (p % nx)) + odd, static_cast<int>(2 * (p / nx % ny)) + odd,
                static_cast<int>(2 * (p / (nx * ny))) + odd};
    }
    [[nodiscard]] Vec3 position(PointId p) const {
        const Int3 h = half(p);
        return origin_ + cell_ / 2 * Vec3(h[0], h[1], h[2]);
    }
    /// Both ends are corners or both are centres.
    [[nodiscard]] bool is_long(PointId a, PointId b) const { return (a < corner_count_) == (b < corner_count_); }

    /// The 14 neighbours of a point of the lattice's interior: 6 along long edges, 8 along short ones.
    template <class Action>
    void for_each_neighbour(PointId p, const Action& action) const {
        const Int3 h = half(p);
        const auto visit = [&](const Int3& n) {
            const int odd = n[0] & 1;
            for (std::size_t i = 0; i < 3; ++i)
                if (n[i] < odd || n[i] > 2 * cubes_[i] - odd) return;
            action(id(n));
        };
        for (std::size_t i = 0; i < 3; ++i)
            for (int step : {-2, 2}) {
                Int3 n = h;
                n[i] += step;
                visit(n);
            }
        for (int x : {-1, 1})
            for (int y : {-1, 1})
                for (int z : {-1, 1}) visit({h[0] + x, h[1] + y, h[2] + z});
    }

 private:
    double cell_;
    Int3 cubes_{};
    Vec3 origin_;
    PointId corner_count_;
};

class Stuffing {
 public:
    Stuffing(const Lattice& lattice, const std::function<bool(const Vec3&)>& inside)
        : lattice_(lattice), inside_(inside) {
        classify();
        find_cuts();
        warp();
    }

    TetMesh mesh() {
        const Int3& n = lattice_.cubes();
        for (int z = 1; z < 2 * n[2]; z += 2)
            for (int y = 1; y < 2 * n[1]; y += 2)
                for (int x = 1; x < 2 * n[0]; x += 2)
                    for (std::size_t axis = 0; axis < 3; ++axis) add_tets_around({x, y, z}, axis);
        return std::move(mesh_);
    }

 private:
    struct Cut {
        PointId a, b;  // a < b; one inside, one outside
        Vec3 position;
    };
    struct EdgeHash {
        std::size_t operator()(const std::pair<PointId, PointId>& e) const {
            const auto a = static_cast<std::uint64_t>(e.first), b = static_cast<std::uint64_t>(e.second);
            return static_cast<std::size_t>(a * 0x9E3779B97F4A7C15U ^ b);
        }
    };

    void classify() {
        sign_.resize(static_cast<std::size_t>(lattice_.size()));
        parallel_for(sign_.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t p = begin; p < end; ++p)
                sign_[p] = inside_(lattice_.position(static_cast<PointId>(p))) ? 1 : -1;
        });
    }

    void find_cuts() {
        for (PointId p = 0; p < lattice_.size(); ++p)
            if (sign(p) > 0)
                lattice_.for_each_neighbour(p, [&](PointId q) {
                    if (sign(q) < 0) cuts_.push_back({std::min(p, q), std::max(p, q), Vec3::Zero()});
                });
        parallel_for(cuts_.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                Cut& cut = cuts_[c];
                Vec3 in = lattice_.position(cut.a), out = lattice_.position(cut.b);
                if (sign(cut.a) < 0) std::swap(in, out);
                for (int i = 0; i < bisections; ++i) {
                    const Vec3 middle = (in + out) / 2;
                    (inside_(middle) ? in : out) = middle;
                }
                cut.position = (in + out) / 2;
            }
        });
        for (std::size_t c = 0; c < cuts_.size(); ++c) cut_of_[{cuts_[c].a, cuts_[c].b}] = c;
    }

    /// Moves each lattice point that has a cut point too close by to the nearest of them (relative to the limits). Its
    /// other cut points vanish with that, so a neighbour may no longer need to move.
    void warp() {
        std::vector<PointId> near;
        for (const Cut& cut : cuts_) near.insert(near.end(), {cut.a, cut.b});
        std::sort(near.begin(), near.end());
        near.erase(std::unique(near.begin(), near.end()), near.end());
        for (PointId p : near) {
            const Vec3 home = lattice_.position(p);
            const Cut* nearest = nullptr;
            double smallest = 1;
            lattice_.for_each_neighbour(p, [&](PointId q) {
                if (sign(q) * sign(p) >= 0) return;  // no cut, or gone because q was warped
                const Cut& cut = cuts_[cut_of_.at({std::min(p, q), std::max(p, q)})];
                const double length = (lattice_.position(q) - home).norm();
                const double limit = (lattice_.is_long(p, q) ? warp_long : warp_short) * length;
                const double relative = (cut.position - home).norm() / limit;
                if (relative < smallest) {
                    smallest = relative;
                    nearest = &cut;
                }
            });
            if (!nearest) continue;
            sign_[static_cast<std::size_t>(p)] = 0;
            warped_[p] = nearest->position;
        }
    }

    /// The four tets around the long edge from a cube's centre to the next one along `axis`.
    void add_tets_around(const Int3& center, std::size_t axis) {
        Int3 next = center;
        next[axis] += 2;
        if (next[axis] > 2 * lattice_.cubes()[axis]) return;
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::array<PointId, 4> ring;
        for (std::size_t k = 0; k < 4; ++k) {
            Int3 corner = center;
            corner[axis] += 1;
            corner[u] += k == 0 || k == 3 ? 1 : -1;
            corner[v] += k < 2 ? 1 : -1;
            ring[k] = lattice_.id(corner);
        }
        const PointId a = lattice_.id(center), b = lattice_.id(next);
        for (std::size_t k = 0; k < 4; ++k) add_stencil({a, b, ring[k], ring[(k + 1) % 4]});
    }

    void add_stencil(const std::array<PointId, 4>& tet) {
        std::array<PointId, 4> plus{}, minus{}, zero{};
        std::size_t np = 0, nm = 0, nz = 0;
        for (PointId p : tet) {
            if (sign(p) > 0) plus[np++] = p;
            if (sign(p) < 0) minus[nm++] = p;
            if (sign(p) == 0) zero[nz++] = p;
        }
        if (np == 0) return;
        if (nm == 0) return add(point(tet[0]), point(tet[1]), point(tet[2]), point(tet[3]));
        if (np == 1) {
            std::array<VertexId, 3> base;
            for (std::size_t i = 0; i < nz; ++i) base[i] = point(zero[i]);
            for (std::size_t i = 0; i < nm; ++i) base[nz + i] = cut(plus[0], minus[i]);
            return add(point(plus[0]), base[0], base[1], base[2]);
        }
        const PointId a = plus[0], b = plus[1], d = minus[0];
        if (np == 2 && nz == 1) {  // a pyramid over the quad a b cut(bd) cut(ad)
            const VertexId apex = point(zero[0]), va = point(a), vb = point(b), ad = cut(a, d), bd = cut(b, d);
            if (diagonal_from_first(a, b, d)) {
                add(apex, va, vb, bd);
                add(apex, va, bd, ad);
            } else {
                add(apex, va, vb, ad);
                add(apex, vb, bd, ad);
            }
            return;
        }
        if (np == 3) {
            const PointId c = plus[2];
            return add_prism(
                {point(a), point(b), point(c)}, {cut(a, d), cut(b, d), cut(c, d)},
                {diagonal_from_first(a, b, d), diagonal_from_first(b, c, d), diagonal_from_first(c, a, d)});
        }
        const PointId c = minus[0], e = minus[1];
        const std::array<VertexId, 3> top = {point(a), cut(a, c), cut(a, e)}, bottom = {point(b), cut(b, c), cut(b, e)};
        const bool first = diagonal_from_first(a, b, c), last = !diagonal_from_first(a, b, e);
        // The third quad lies on the boundary: no neighbour, so free unless all three diagonals would form a cycle.
        const auto length = [&](VertexId x, VertexId y) {
            return (mesh_.positions[x] - mesh_.positions[y]).squaredNorm();
        };
        const bool middle = first == last ? !first : length(top[1], bottom[2]) < length(top[2], bottom[1]);
        add_prism(top, bottom, {first, middle, last});
    }

    /// The face with a, b inside and d outside leaves a quad; both tets that share it must cut it along the same
    /// diagonal. True: from a to the cut point of b. Where one cut edge is long, the diagonal ends at its cut point
    /// (the other choice breaks the bound on the angles). Where both are short, a and b differ from d by half a cell
    /// along each axis and from each other along one, so exactly one of them is above d in an even number of
    /// coordinates: it starts there.
    [[nodiscard]] bool diagonal_from_first(PointId a, PointId b, PointId d) const {
        if (lattice_.is_long(a, d)) return false;
        if (lattice_.is_long(b, d)) return true;
        const Int3 ha = lattice_.half(a), hd = lattice_.half(d);
        int above = 0;
        for (std::size_t i = 0; i < 3; ++i) above += ha[i] > hd[i] ? 1 : 0;
        return above % 2 == 0;
    }

    /// diagonal[k]: from top[k] to bottom[k+1], else from top[k+1] to bottom[k]; not all equal.
    void add_prism(const std::array<VertexId, 3>& top, const std::array<VertexId, 3>& bottom,
                   const std::array<bool, 3>& diagonal) {
        std::size_t k = 0;
        while (k < 3 && !(diagonal[k] && !diagonal[(k + 2) % 3])) ++k;
        ENSURE(k < 3, "the diagonals of a prism form a cycle");
        const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
        add(top[k], bottom[0], bottom[1], bottom[2]);  // both diagonals at top[k] end here
        if (diagonal[l]) {
            add(top[k], top[l], top[m], bottom[m]);
            add(top[k], top[l], bottom[m], bottom[l]);
        } else {
            add(top[k], top[l], top[m], bottom[l]);
            add(top[k], top[m], bottom[m], bottom[l]);
        }
    }

    void add(VertexId a, VertexId b, VertexId c, VertexId d) {
        const auto& x = mesh_.positions;
        if (signed_volume(x[a], x[b], x[c], x[d]) < 0) std::swap(c, d);
        mesh_.corners.push_back({a, b, c, d});
    }

    [[nodiscard]] int sign(PointId p) const { return sign_[static_cast<std::size_t>(p)]; }

    VertexId point(PointId p) {
        const auto [entry, fresh] =
            point_vertex_.try_emplace(p, VertexId(static_cast<std::int64_t>(mesh_.positions.size())));
        if (fresh) {
            const auto moved = warped_.find(p);
            mesh_.positions.push_back(moved == warped_.end() ? lattice_.position(p) : moved->second);
        }
        return entry->second;
    }

    VertexId cut(PointId a, PointId b) {
        const std::size_t c = cut_of_.at({std::min(a, b), std::max(a, b)});
        const auto [entry, fresh] =
            cut_vertex_.try_emplace(c, VertexId(static_cast<std::int64_t>(mesh_.positions.size())));
        if (fresh) mesh_.positions.push_back(cuts_[c].position);
        return entry->second;
    }

    const Lattice& lattice_;
    const std::function<bool(const Vec3&)>& inside_;
    std::vector<signed char> sign_;  // [lattice points] 1 inside, -1 outside, 0 warped onto the boundary
    std::vector<Cut> cuts_;
    std::unordered_map<std::pair<PointId, PointId>, std::size_t, EdgeHash> cut_of_;
    std::unordered_map<PointId, Vec3> warped_;
    std::unordered_map<PointId, VertexId> point_vertex_;
    std::unordered_map<std::size_t, VertexId> cut_vertex_;
    TetMesh mesh_;
};

}  // namespace

TetMesh stuff_isosurface(const Vec3& low, const Vec3& high, double cell,
                         const std::function<bool(const Vec3&)>& inside) {
    ENSURE(cell > 0 && low.allFinite() && high.allFinite() && (low.array() <= high.array()).all(), "cell ", cell);
    const Lattice lattice(low, high, cell);
    return Stuffing(lattice, inside).mesh();
}

}  // namespace tetfront
