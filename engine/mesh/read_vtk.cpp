// VTK legacy files, text and binary (big endian), up to version 5.1. https://examples.vtk.org: VTK file formats.

#include "engine/mesh/scanner.hpp"
#include "engine/mesh/tet_readers.hpp"
#include "engine/mesh/vtk_cells.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace tetfront {

namespace {

std::string lower(std::string_view word) {
    std::string out(word);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return out;
}

class VtkReader {
 public:
    VtkReader(std::string_view bytes, const std::string& file) : in_(bytes, file) {}

    RawTets read() {
        read_header();
        while (!in_.at_end()) {
            const std::string section = lower(in_.word("a section"));
            if (section == "points") {
                read_points();
            } else if (section == "cells") {
                read_cells();
            } else if (section == "cell_types") {
                const std::size_t n = count("cell types", VtkType::int32, 1);
                types_ = integers(n, VtkType::int32);
            } else if (section == "cell_data" || section == "point_data") {
                in_cell_data_ = section == "cell_data";
                tuples_ = static_cast<std::size_t>(in_.integer("the number of tuples", 0, INT32_MAX));
            } else if (section == "field") {
                read_field();
            } else if (section == "metadata") {
                skip_metadata();
            } else {
                read_attribute(section);
            }
        }
        if (raw_.positions.empty() || !has_cells_ || !types_)
            in_.fail("lacks points, cells or cell types", "the file is cut off or broken: export it again");
        const VtkCellData* region = find_region(cell_data_);
        static const std::vector<std::int64_t> none;
        if (region && region->values.size() != ends_.size())
            in_.fail("has " + std::to_string(region->values.size()) + " regions for " + std::to_string(ends_.size()) +
                         " cells",
                     "the file is broken: export it again");
        append_cells(raw_, 0, connectivity_, ends_, *types_, region ? region->values : none,
                     [&](const std::string& problem, const std::string& remedy) { in_.fail(problem, remedy); });
        return std::move(raw_);
    }

 private:
    void read_header() {
        constexpr std::string_view magic = "# vtk DataFile Version ";
        const std::string_view first = in_.line();
        if (!first.starts_with(magic)) in_.fail("should begin with '# vtk DataFile Version'", "use a VTK legacy file");
        old_cells_ = first.size() > magic.size() && first[magic.size()] < '5';
        in_.line();  // title
        const std::string format = lower(in_.word("ASCII or BINARY"));
        if (format != "ascii" && format != "binary") in_.fail("ASCII or BINARY is expected", "the file is broken");
        binary_ = format == "binary";
        if (lower(in_.word("DATASET")) != "dataset") in_.fail("DATASET is expected", "the file is broken");
        if (lower(in_.word("a kind of data set")) != "unstructured_grid")
            in_.fail("is no unstructured grid", "use a mesh with tetrahedra");
    }

    VtkType type(std::string_view word) {
        static constexpr std::array<std::pair<std::string_view, VtkType>, 15> types = {
            {{"char", VtkType::int8},
             {"signed_char", VtkType::int8},
             {"unsigned_char", VtkType::uint8},
             {"short", VtkType::int16},
             {"unsigned_short", VtkType::uint16},
             {"int", VtkType::int32},
             {"vtkidtype", VtkType::int32},
             {"unsigned_int", VtkType::uint32},
             {"long", VtkType::int64},
             {"vtktypeint64", VtkType::int64},
             {"unsigned_long", VtkType::uint64},
             {"vtktypeuint64", VtkType::uint64},
             {"float", VtkType::float32},
             {"double", VtkType::float64},
             {"long_long", VtkType::int64}}};
        const std::string name = lower(word);
        for (const auto& [known, value] : types)
            if (known == name) return value;
        in_.fail("has values of the type '" + name.substr(0, 40) + "'", "use numbers");
    }
    VtkType read_type() { return type(in_.word("a type")); }

    // Values follow on the next line.
    std::size_t count(std::string_view what, VtkType t, std::size_t each) {
        return in_.count(what, each * (binary_ ? size_of(t) : 2));
    }
    std::string_view block(std::size_t n, VtkType t) {
        in_.line();
        in_.set_binary(true);
        in_.expect(n, size_of(t), "values");
        const std::string_view data = in_.bytes(n * size_of(t), "values");
        in_.set_binary(false);
        return data;
    }
    std::vector<double> reals(std::size_t n, VtkType t) {
        std::vector<double> values;
        if (binary_) {
            const std::string_view data = block(n, t);
            for (std::size_t i = 0; i < n; ++i) values.push_back(load_real(data.data() + i * size_of(t), t, true));
        } else {
            in_.expect(n, 2, "values");
            for (std::size_t i = 0; i < n; ++i) values.push_back(in_.real("a value"));
        }
        return values;
    }
    std::vector<std::int64_t> integers(std::size_t n, VtkType t) {
        std::vector<std::int64_t> values;
        if (binary_) {
            const std::string_view data = block(n, t);
            for (std::size_t i = 0; i < n; ++i) values.push_back(load_integer(data.data() + i * size_of(t), t, true));
        } else {
            in_.expect(n, 2, "values");
            for (std::size_t i = 0; i < n; ++i) values.push_back(in_.integer("a whole number"));
        }
        return values;
    }
    void skip(std::size_t n, VtkType t) {
        if (binary_)
            block(n, t);
        else
            for (std::size_t i = 0; i < n; ++i) in_.word("a value");
    }

    void read_points() {
        if (!raw_.positions.empty()) in_.fail("has POINTS twice", "the file is broken");
        const std::size_t n = in_.count("points", 3);
        const VtkType t = read_type();
        const std::vector<double> x = reals(3 * n, t);
        for (std::size_t i = 0; i < n; ++i) {
            raw_.positions.emplace_back(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
            if (!raw_.positions.back().allFinite())
                in_.fail("point " + std::to_string(i) + " is not finite", "coordinates must be finite numbers");
        }
    }

    void read_cells() {
        if (has_cells_) in_.fail("has CELLS twice", "the file is broken");
        has_cells_ = true;
        const std::size_t n = in_.count("cells", 1), size = in_.count("cell entries", 1);
        if (!old_cells_) {
            if (lower(in_.word("OFFSETS")) != "offsets") in_.fail("OFFSETS is expected", "the file is broken");
            const VtkType offset_type = read_type();
            ends_ = integers(n, offset_type);
            if (lower(in_.word("CONNECTIVITY")) != "connectivity")
                in_.fail("CONNECTIVITY is expected", "the file is broken");
            const VtkType connectivity_type = read_type();
            connectivity_ = integers(size, connectivity_type);
            if (!ends_.empty()) {
                if (ends_[0] != 0) in_.fail("its first offset is not 0", "the file is broken");
                ends_.erase(ends_.begin());
            }
            return;
        }
        const std::vector<std::int64_t> list = integers(size, VtkType::int32);
        std::size_t next = 0;
        for (std::size_t cell = 0; cell < n; ++cell) {
            const std::int64_t corners = next < size ? list[next++] : -1;
            if (corners < 0 || static_cast<std::uint64_t>(corners) > size - next)
                in_.fail("cell " + std::to_string(cell) + " does not fit into the list of " + std::to_string(size),
                         "the file is broken");
            for (std::int64_t i = 0; i < corners; ++i) connectivity_.push_back(list[next++]);
            ends_.push_back(static_cast<std::int64_t>(connectivity_.size()));
        }
    }

    void take(const std::string& name, std::size_t n, std::size_t components, VtkType t) {
        if (in_cell_data_ && components == 1 && is_integer(t))
            cell_data_.push_back({name, integers(n, t)});
        else
            skip(product(n, components), t);
    }
    std::size_t product(std::size_t n, std::size_t components) {
        if (components == 0) return 0;
        in_.expect(n, components, "tuples");  // each value takes a byte at least
        return n * components;
    }

    void read_field() {
        in_.word("a field's name");
        const std::size_t arrays = in_.count("arrays", 4);
        for (std::size_t i = 0; i < arrays; ++i) {
            std::string name(in_.word("an array's name"));
            if (lower(name) == "metadata") {
                skip_metadata();
                name = in_.word("an array's name");
            }
            const std::size_t components = in_.count("components", 1);
            const auto n = static_cast<std::size_t>(in_.integer("the number of tuples", 0, INT32_MAX));
            const VtkType t = read_type();
            take(name, n, components, t);
        }
    }

    /// Ends with an empty line.
    void skip_metadata() {
        in_.line();
        while (!in_.out_of_text() && !in_.line().empty()) {
        }
    }

    void read_attribute(const std::string& kind) {
        const std::string name(in_.word("a name"));
        if (kind == "scalars") {
            const VtkType t = read_type();
            std::size_t components = 1;
            // The number of components is optional: it is a number, or the next word is LOOKUP_TABLE.
            if (lower(in_.peek()) != "lookup_table")
                components = static_cast<std::size_t>(in_.integer("1 to 4 components", 1, 4));
            if (lower(in_.word("LOOKUP_TABLE")) != "lookup_table")
                in_.fail("LOOKUP_TABLE is expected", "the file is broken");
            in_.word("a table's name");
            take(name, tuples_, components, t);
        } else if (kind == "color_scalars") {
            skip(product(tuples_, static_cast<std::size_t>(in_.integer("1 to 4 values", 1, 4))), VtkType::uint8);
        } else if (kind == "lookup_table") {
            skip(product(static_cast<std::size_t>(in_.integer("a size", 0, INT32_MAX)), 4), VtkType::uint8);
        } else if (kind == "vectors" || kind == "normals") {
            skip(product(tuples_, 3), read_type());
        } else if (kind == "tensors") {
            skip(product(tuples_, 9), read_type());
        } else if (kind == "tensors6") {
            skip(product(tuples_, 6), read_type());
        } else if (kind == "global_ids" || kind == "pedigree_ids") {
            skip(tuples_, read_type());
        } else if (kind == "texture_coordinates") {
            const auto components = static_cast<std::size_t>(in_.integer("1 to 3 components", 1, 3));
            skip(product(tuples_, components), read_type());
        } else {
            in_.fail("the section '" + kind.substr(0, 40) + "' is unknown", "the file is broken: export it again");
        }
    }

    Scanner in_;
    bool binary_ = false, old_cells_ = true, has_cells_ = false, in_cell_data_ = false;
    std::size_t tuples_ = 0;
    RawTets raw_;
    std::vector<std::int64_t> connectivity_, ends_;
    std::optional<std::vector<std::int64_t>> types_;
    std::vector<VtkCellData> cell_data_;
};

}  // namespace

RawTets read_vtk_legacy(std::string_view bytes, const std::string& file) { return VtkReader(bytes, file).read(); }

}  // namespace tetfront
