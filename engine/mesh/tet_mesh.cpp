#include "engine/mesh/tet_mesh.hpp"

#include "engine/base/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

namespace tetfront {

namespace {

/// Local corners of the face opposite to corner i, counter-clockwise seen from outside of a positive tet.
constexpr std::array<std::array<int, 3>, 4> face_corners = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// A face of a tet, comparable by its vertices.
struct Face {
    std::array<VertexId, 3> sorted;
    bool even;  // sorting it took an even permutation: two tets see their common face with opposite parity
    TetId tet;
    int opposite;  // local corner
};

std::vector<Face> sorted_faces(const TetMesh& mesh) {
    std::vector<Face> faces;
    faces.reserve(4 * mesh.corners.size());
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        for (int i = 0; i < 4; ++i) {
            const auto& local = face_corners[static_cast<std::size_t>(i)];
            std::array<VertexId, 3> v;
            for (std::size_t k = 0; k < 3; ++k) v[k] = mesh.corners[t][static_cast<std::size_t>(local[k])];
            bool even = true;
            for (auto [a, b] : {std::pair{0, 1}, {1, 2}, {0, 1}}) {
                if (v[static_cast<std::size_t>(b)] < v[static_cast<std::size_t>(a)]) {
                    std::swap(v[static_cast<std::size_t>(a)], v[static_cast<std::size_t>(b)]);
                    even = !even;
                }
            }
            faces.push_back({v, even, t, i});
        }
    }
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
        return std::tie(a.sorted, a.tet, a.opposite) < std::tie(b.sorted, b.tet, b.opposite);
    });
    return faces;
}

/// action(first, last) for each group of faces with the same vertices.
template <class Action>
void for_each_shared_face(const std::vector<Face>& faces, const Action& action) {
    for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
        while (end < faces.size() && faces[end].sorted == faces[begin].sorted) ++end;
        action(begin, end);
    }
}

std::string short_text(double x) {
    std::ostringstream out;
    out << x;
    return out.str();
}
std::string name(TetId t) { return "tet " + std::to_string(t.value); }
std::string name(VertexId v) { return "vertex " + std::to_string(v.value); }

}  // namespace

double signed_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return (b - a).cross(c - a).dot(d - a) / 6;
}

std::array<double, 2> dihedral_range(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const std::array<Vec3, 4> x = {a, b, c, d};
    std::array<Vec3, 4> normal;  // outward, of the face opposite to each corner
    for (std::size_t i = 0; i < 4; ++i) {
        const auto& f = face_corners[i];
        const Vec3& origin = x[static_cast<std::size_t>(f[0])];
        normal[i] = (x[static_cast<std::size_t>(f[1])] - origin).cross(x[static_cast<std::size_t>(f[2])] - origin);
        if (!(normal[i].norm() > 0)) return {0, 180};
        normal[i].normalize();
    }
    std::array<double, 2> range = {180, 0};
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = i + 1; j < 4; ++j) {
            // atan2 keeps its accuracy near 0 and 180 degrees, where acos loses half of the digits.
            const double between = std::atan2(normal[i].cross(normal[j]).norm(), normal[i].dot(normal[j]));
            const double angle = 180 - between * 180 / std::numbers::pi;
            range = {std::min(range[0], angle), std::max(range[1], angle)};
        }
    }
    return range;
}

void validate(const TetMesh& mesh) {
    const auto fail = [](const std::string& where, const std::string& problem, const std::string& remedy = {}) {
        throw InputError{"", where, problem, remedy};
    };
    if (mesh.corners.empty()) fail("tet mesh", "has no tets");
    if (!mesh.region.empty() && mesh.region.size() != mesh.corners.size())
        fail("tet mesh", "has " + std::to_string(mesh.region.size()) + " regions for " +
                             std::to_string(mesh.corners.size()) + " tets");
    for (VertexId v : ids<VertexId>(mesh.positions.size()))
        if (!mesh.positions[v].allFinite()) fail(name(v), "has a position that is not finite");

    PerVertex<char> used(mesh.positions.size(), 0);
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        const auto& c = mesh.corners[t];
        for (VertexId v : c) {
            if (v.value < 0 || v.index() >= mesh.positions.size())
                fail(name(t), "refers to vertex " + std::to_string(v.value),
                     "vertices are numbered 0 to " + std::to_string(mesh.positions.size() - 1));
            used[v] = 1;
        }
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j)
                if (c[i] == c[j]) fail(name(t), "has " + name(c[i]) + " at two corners");
        const double volume =
            signed_volume(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]], mesh.positions[c[3]]);
        if (!(volume > 0) || !std::isfinite(volume))
            fail(name(t), "has the volume " + short_text(volume) + " m^3",
                 "volumes must be positive: exchange two corners of an inverted tet, remove a flat one");
    }
    for (VertexId v : ids<VertexId>(mesh.positions.size()))
        if (!used[v]) fail(name(v), "belongs to no tet", "remove it");

    const std::vector<Face> faces = sorted_faces(mesh);
    for_each_shared_face(faces, [&](std::size_t begin, std::size_t end) {
        if (end - begin > 2)
            fail(name(faces[begin].tet), "has a face that " + std::to_string(end - begin) + " tets share",
                 "two at most may meet in a face; the third is " + name(faces[begin + 2].tet));
        if (end - begin == 2 && faces[begin].even == faces[begin + 1].even)
            fail(name(faces[begin].tet), "lies on the same side of a common face as " + name(faces[begin + 1].tet),
                 "remove one of the two: tets must not overlap");
    });
}

TetMesh box_mesh(const Vec3& low, const Vec3& high, const std::array<int, 3>& cells) {
    for (int i = 0; i < 3; ++i) {
        if (!(low[i] < high[i]) || !std::isfinite(high[i] - low[i]))
            throw InputError{"", "box mesh", "is empty along axis " + std::to_string(i), "use low < high"};
        if (cells[static_cast<std::size_t>(i)] < 1)
            throw InputError{"", "box mesh", "has no cells along axis " + std::to_string(i), "use at least 1"};
    }
    const std::array<std::int64_t, 3> n = {cells[0], cells[1], cells[2]};
    const double tets = 6.0 * static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]);
    if (tets > 256e6) throw InputError{"", "box mesh", "would have more than 256 million tets", "use fewer cells"};

    TetMesh mesh;
    for (std::int64_t k = 0; k <= n[2]; ++k)
        for (std::int64_t j = 0; j <= n[1]; ++j)
            for (std::int64_t i = 0; i <= n[0]; ++i) {
                const Vec3 fraction(static_cast<double>(i) / cells[0], static_cast<double>(j) / cells[1],
                                    static_cast<double>(k) / cells[2]);
                mesh.positions.push_back(low.cwiseProduct(Vec3::Ones() - fraction) + high.cwiseProduct(fraction));
            }
    const std::array<std::int64_t, 3> stride = {1, n[0] + 1, (n[0] + 1) * (n[1] + 1)};

    // Each tet of a cube walks from its lowest to its highest corner along the axes in one of six orders. Refining
    // looks only at which corners are paired (0-2 and 1-3), so the odd orders swap 0 and 2: positive volume, and all
    // descendants keep the shape of their root.
    constexpr std::array<std::array<std::size_t, 3>, 6> orders = {
        {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
    mesh.corners.reserve(static_cast<std::size_t>(tets));
    for (std::int64_t k = 0; k < n[2]; ++k)
        for (std::int64_t j = 0; j < n[1]; ++j)
            for (std::int64_t i = 0; i < n[0]; ++i)
                for (std::size_t o = 0; o < orders.size(); ++o) {
                    std::int64_t v = i * stride[0] + j * stride[1] + k * stride[2];
                    std::array<VertexId, 4> path = {VertexId(v)};
                    for (std::size_t step = 0; step < 3; ++step)
                        path[step + 1] = VertexId(v += stride[orders[o][step]]);
                    if (o >= 3) std::swap(path[0], path[2]);
                    mesh.corners.push_back(path);
                }
    return mesh;
}

SurfaceMesh boundary_surface(const TetMesh& mesh) {
    const std::vector<Face> faces = sorted_faces(mesh);
    std::vector<Face> boundary;
    for_each_shared_face(faces, [&](std::size_t begin, std::size_t end) {
        if (end - begin == 1) boundary.push_back(faces[begin]);
    });
    std::sort(boundary.begin(), boundary.end(),
              [](const Face& a, const Face& b) { return std::tie(a.tet, a.opposite) < std::tie(b.tet, b.opposite); });

    PerVertex<std::int32_t> compact(mesh.positions.size(), -1);
    for (const Face& face : boundary)
        for (VertexId v : face.sorted) compact[v] = 0;
    SurfaceMesh surface;
    for (VertexId v : ids<VertexId>(mesh.positions.size())) {
        if (compact[v] < 0) continue;
        compact[v] = static_cast<std::int32_t>(surface.positions.size());
        surface.positions.push_back(mesh.positions[v]);
    }
    for (const Face& face : boundary) {
        const auto& local = face_corners[static_cast<std::size_t>(face.opposite)];
        const auto& c = mesh.corners[face.tet];
        surface.triangles.push_back({compact[c[static_cast<std::size_t>(local[0])]],
                                     compact[c[static_cast<std::size_t>(local[1])]],
                                     compact[c[static_cast<std::size_t>(local[2])]]});
    }
    return surface;
}

}  // namespace tetfront
