// Gmsh .msh, versions 1 ($NOD), 2.x and 4.1, text and binary of either byte order. https://gmsh.info/doc: MSH file
// format.

#include "engine/mesh/scanner.hpp"
#include "engine/mesh/tet_readers.hpp"

#include <cmath>
#include <cstdlib>
#include <optional>
#include <unordered_map>

namespace tetfront {

namespace {

constexpr std::int64_t max_int = INT32_MAX;

/// Nodes of an element type; 0: unknown. Types 1..31 are Gmsh's lines to fifth-order tets.
std::size_t nodes_of_type(std::int64_t type) {
    static constexpr std::array<std::size_t, 32> nodes = {0, 2,  3,  4,  4, 8,  6,  5,  3,  6,  9, 10, 27, 18, 14, 1,
                                                          8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5,  6,  20, 35, 56};
    return type >= 1 && type <= 31 ? nodes[static_cast<std::size_t>(type)] : 0;
}

class GmshReader {
 public:
    GmshReader(std::string_view bytes, const std::string& file) : in_(bytes, file) {}

    RawTets read() {
        bool nodes = false, elements = false;
        while (!in_.at_end()) {
            const std::string section(in_.word("a section"));
            if (section.size() < 2 || section[0] != '$')
                in_.fail("a section that begins with $ is expected", "the file is no Gmsh mesh or broken");
            if (section == "$MeshFormat") {
                read_format();
            } else if (section == "$NOD") {
                version_ = 1;
                read_nodes_2();
                nodes = true;
            } else if (section == "$ELM") {
                version_ = 1;
                read_elements_1();
                elements = true;
            } else if (section == "$Entities" || section == "$Nodes" || section == "$Elements") {
                if (version_ == 0)
                    in_.fail(section + " comes before $MeshFormat", "the file is broken: export it again");
                begin_data();
                if (section == "$Entities")
                    read_entities();
                else if (section == "$Nodes")
                    (version_ >= 4 ? read_nodes_4() : read_nodes_2()), nodes = true;
                else
                    (version_ >= 4 ? read_elements_4() : read_elements_2()), elements = true;
                in_.set_binary(false);
            } else {
                in_.skip_behind("$End" + section.substr(1));
                continue;
            }
            const std::string end = section == "$NOD"   ? "$ENDNOD"
                                    : section == "$ELM" ? "$ENDELM"
                                                        : "$End" + section.substr(1);
            if (in_.word(end) != end) in_.fail(end + " is expected", "the file is broken: export it again");
        }
        if (!nodes || !elements) in_.fail("holds no nodes or no elements", "export the mesh, not only the geometry");
        if (unsupported_ && raw_.corners.empty())
            in_.fail("its volume elements are no tets", "mesh the volume with tetrahedra");
        if (unsupported_)
            in_.fail(std::to_string(unsupported_) + " volume elements are no tets", "split them into tetrahedra");
        return std::move(raw_);
    }

 private:
    void read_format() {
        const double version = in_.real("a version");
        if (!((version >= 2 && version < 3) || std::abs(version - 4.1) < 1e-6))
            in_.fail("has the format version " + std::to_string(version).substr(0, 4),
                     "save it as version 2.2 or 4.1 (Mesh.MshFileVersion)");
        version_ = version >= 4 ? 4 : 2;
        binary_ = in_.integer("the file type", 0, 1) == 1;
        if (in_.integer("the data size", 4, 8) != 8)
            in_.fail("has a data size other than 8", "save it with 8-byte numbers");
        if (!binary_) return;
        in_.line();
        const std::string_view one = in_.bytes(4, "the byte order");
        if (load<std::int32_t>(one.data(), false) == 1)
            big_endian_ = false;
        else if (load<std::int32_t>(one.data(), true) == 1)
            big_endian_ = true;
        else
            in_.fail("its byte order is unknown", "the file is broken: export it again");
    }

    void begin_data() {
        if (!binary_) return;
        in_.line();
        in_.set_binary(true);
    }

    // Numbers as the file has them: words, or 4- and 8-byte values.
    std::int64_t small(std::string_view what, std::int64_t low = -max_int - 1, std::int64_t high = max_int) {
        if (!binary_) return in_.integer(what, low, high);
        return checked(load<std::int32_t>(in_.bytes(4, what).data(), big_endian_), what, low, high);
    }
    std::int64_t large(std::string_view what, std::int64_t low = INT64_MIN, std::int64_t high = INT64_MAX) {
        if (!binary_) return in_.integer(what, low, high);
        return checked(load<std::int64_t>(in_.bytes(8, what).data(), big_endian_), what, low, high);
    }
    std::int64_t checked(std::int64_t value, std::string_view what, std::int64_t low, std::int64_t high) {
        if (value < low || value > high)
            in_.fail(std::to_string(value) + " is out of range for " + std::string(what), "the file is broken");
        return value;
    }
    double real(std::string_view what) {
        if (!binary_) return in_.real(what);
        const double value = load<double>(in_.bytes(8, what).data(), big_endian_);
        if (!std::isfinite(value)) in_.fail(std::string(what) + " is not finite", "coordinates must be finite numbers");
        return value;
    }
    /// n things of so many small and large numbers each may follow.
    std::size_t expect(std::int64_t n, std::size_t smalls, std::size_t larges, std::string_view what) {
        in_.expect(static_cast<std::uint64_t>(n), binary_ ? 4 * smalls + 8 * larges : 2 * (smalls + larges), what);
        return static_cast<std::size_t>(n);
    }

    void add_node(std::int64_t tag, const Vec3& x) {
        if (!index_.try_emplace(tag, static_cast<std::int32_t>(raw_.positions.size())).second)
            in_.fail("node " + std::to_string(tag) + " appears twice", "renumber the nodes");
        raw_.positions.push_back(x);
    }
    Vec3 point() {
        const double x = real("a coordinate"), y = real("a coordinate"), z = real("a coordinate");
        return {x, y, z};
    }

    void read_nodes_2() {
        const std::size_t n = version_ == 1 || !binary_ ? in_.count("nodes", 8) : text_count("nodes", 28);
        for (std::size_t i = 0; i < n; ++i) {
            const std::int64_t tag = small("a node's number");
            add_node(tag, point());
        }
    }
    /// In version 2 counts are text also in binary files.
    std::size_t text_count(std::string_view what, std::size_t bytes_each) {
        const std::size_t n = in_.count(what, bytes_each);
        in_.line();
        return n;
    }

    void read_elements_1() {
        const std::size_t n = in_.count("elements", 12);
        for (std::size_t i = 0; i < n; ++i) {
            small("an element's number");
            const std::int64_t type = small("an element type");
            const std::int64_t region = small("a region");
            small("a region");
            const auto nodes = static_cast<std::size_t>(in_.integer("the number of nodes", 1, 100));
            element(type, nodes, region, false);
        }
    }

    void read_elements_2() {
        if (!binary_) {
            const std::size_t n = in_.count("elements", 8);
            for (std::size_t i = 0; i < n; ++i) {
                small("an element's number");
                const std::int64_t type = small("an element type");
                const std::int64_t region = tags(expect(small("the number of tags", 0), 1, 0, "tags"));
                element(type, nodes_of_type(type), region, false);
            }
            return;
        }
        // Elements of one type come in blocks.
        for (std::size_t left = text_count("elements", 4); left > 0;) {
            const std::int64_t type = small("an element type");
            const std::int64_t n = small("the number of elements", 1);
            const std::int64_t tag_count = small("the number of tags", 0);
            const std::size_t nodes = nodes_of_type(type);
            expect(tag_count, 1, 0, "tags");
            expect(n, 1 + static_cast<std::size_t>(tag_count) + nodes, 0, "elements");
            if (static_cast<std::size_t>(n) > left) in_.fail("has more elements than announced", "the file is broken");
            left -= static_cast<std::size_t>(n);
            for (std::int64_t i = 0; i < n; ++i) {
                small("an element's number");
                const std::int64_t region = tags(static_cast<std::size_t>(tag_count));
                element(type, nodes, region, false);
            }
        }
    }
    /// The first tag is the physical group.
    std::int64_t tags(std::size_t count) {
        std::int64_t first = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::int64_t tag = small("a tag");
            if (i == 0) first = tag;
        }
        return first;
    }

    void read_entities() {
        std::array<std::int64_t, 4> count;
        for (std::int64_t& n : count) n = large("the number of entities", 0);
        for (std::size_t dimension = 0; dimension < 4; ++dimension) {
            const std::size_t reals = dimension == 0 ? 3 : 6;
            const std::size_t n = expect(count[dimension], 1, reals + 1, "entities");
            for (std::size_t i = 0; i < n; ++i) {
                const std::int64_t tag = small("an entity's number");
                for (std::size_t k = 0; k < reals; ++k) real("a coordinate of a box");
                const std::size_t groups = expect(large("the number of groups", 0), 1, 0, "groups");
                const std::int64_t group = tags(groups);
                if (dimension == 3 && groups > 0) group_of_volume_[tag] = std::abs(group);
                if (dimension > 0) tags(expect(large("the number of bounding entities", 0), 1, 0, "entities"));
            }
        }
    }

    void read_nodes_4() {
        const std::int64_t blocks = large("the number of blocks", 0);
        large("the number of nodes", 0), large("the smallest node"), large("the largest node");
        for (std::int64_t block = 0; block < blocks; ++block) {
            const std::int64_t dimension = small("a dimension", 0, 3);
            small("an entity");
            const std::int64_t parametric = small("0 or 1", 0, 1);
            const std::size_t n = expect(large("the number of nodes", 0), 0, 4, "nodes");
            std::vector<std::int64_t> numbers;
            for (std::size_t i = 0; i < n; ++i) numbers.push_back(large("a node's number"));
            for (std::size_t i = 0; i < n; ++i) {
                add_node(numbers[i], point());
                for (std::int64_t k = 0; k < parametric * dimension; ++k) real("a parameter");
            }
        }
    }

    void read_elements_4() {
        const std::int64_t blocks = large("the number of blocks", 0);
        large("the number of elements", 0), large("the smallest element"), large("the largest element");
        for (std::int64_t block = 0; block < blocks; ++block) {
            const std::int64_t dimension = small("a dimension", 0, 3);
            const std::int64_t entity = small("an entity");
            const std::int64_t type = small("an element type");
            const std::size_t nodes = nodes_of_type(type);
            const std::size_t n = expect(large("the number of elements", 0), 0, 1 + nodes, "elements");
            const auto group = dimension == 3 ? group_of_volume_.find(entity) : group_of_volume_.end();
            for (std::size_t i = 0; i < n; ++i) {
                large("an element's number");
                element(type, nodes, group == group_of_volume_.end() ? 0 : group->second, true);
            }
        }
    }

    void element(std::int64_t type, std::size_t nodes, std::int64_t region, bool large_numbers) {
        if (nodes == 0)
            in_.fail("the element type " + std::to_string(type) + " is unknown",
                     "mesh with tetrahedra of order 1 or 2");
        const bool tet = type == 4 || type == 11;
        if (tet && nodes < 4) in_.fail("a tet has fewer than 4 nodes", "the file is broken");
        std::array<std::int32_t, 4> corners{};
        for (std::size_t i = 0; i < nodes; ++i) {
            const std::int64_t tag = large_numbers ? large("a node") : small("a node");
            if (!tet || i >= 4) continue;
            const auto found = index_.find(tag);
            if (found == index_.end())
                in_.fail("tet " + std::to_string(raw_.corners.size()) + " refers to node " + std::to_string(tag),
                         "there is no node with this number");
            corners[i] = found->second;
        }
        if (tet) {
            raw_.corners.push_back(corners);
            raw_.region.push_back(static_cast<std::int32_t>(region));
            raw_.repairs.straightened_tets += type == 11 ? 1 : 0;
            return;
        }
        static constexpr std::array flat_types = {1, 2, 3, 8, 9, 10, 15, 16, 20, 21, 22, 23, 24, 25, 26, 27, 28};
        for (int flat : flat_types)
            if (type == flat) {
                ++raw_.repairs.ignored_cells;
                return;
            }
        ++unsupported_;
    }

    Scanner in_;
    int version_ = 0;  // 1, 2 or 4
    bool binary_ = false, big_endian_ = false;
    RawTets raw_;
    std::size_t unsupported_ = 0;
    std::unordered_map<std::int64_t, std::int32_t> index_;            // node number -> position
    std::unordered_map<std::int64_t, std::int64_t> group_of_volume_;  // entity -> physical group
};

}  // namespace

RawTets read_gmsh(std::string_view bytes, const std::string& file) { return GmshReader(bytes, file).read(); }

}  // namespace tetfront
