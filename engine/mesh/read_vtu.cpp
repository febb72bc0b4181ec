// VTK XML unstructured grids (.vtu): text, base64 and appended data, both byte orders, zlib.

#include "engine/base/error.hpp"
#include "engine/mesh/scanner.hpp"
#include "engine/mesh/tet_readers.hpp"
#include "engine/mesh/vtk_cells.hpp"
#include "engine/mesh/vtk_payload.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <tuple>

#include <pugixml.hpp>

namespace tetfront {

namespace {

/// More elements than that are no mesh, and each takes far more memory than text.
constexpr std::ptrdiff_t max_elements = 1'000'000;

class VtuReader {
 public:
    VtuReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

    RawTets read() {
        parse();
        const pugi::xml_node root = document_.child("VTKFile");
        if (!root) fail(document_, "is no VTK file", "it should hold an element VTKFile");
        if (std::strcmp(root.attribute("type").value(), "UnstructuredGrid") != 0)
            fail(root, std::string("holds '") + std::string(root.attribute("type").value()).substr(0, 40) + "'",
                 "an UnstructuredGrid is needed (of a parallel file: read its pieces)");
        const std::string order = root.attribute("byte_order").value(), header = root.attribute("header_type").value(),
                          compressor = root.attribute("compressor").value();
        if (order != "LittleEndian" && order != "BigEndian" && !order.empty())
            fail(root, "has an unknown byte_order", "use LittleEndian");
        if (header != "UInt32" && header != "UInt64" && !header.empty())
            fail(root, "has an unknown header_type", "use UInt64");
        if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
            fail(root, "is compressed with " + compressor.substr(0, 40), "save it with zlib or without compression");
        encoding_.big_endian = order == "BigEndian";
        encoding_.header = header == "UInt64" ? VtkType::uint64 : VtkType::uint32;
        encoding_.zlib = !compressor.empty();
        appended_base64_ = std::strcmp(root.child("AppendedData").attribute("encoding").value(), "raw") != 0;
        std::size_t pieces = 0;
        for (const pugi::xml_node piece : root.child("UnstructuredGrid").children("Piece")) {
            read_piece(piece);
            ++pieces;
        }
        if (pieces == 0) fail(root, "has no Piece", "the file is broken: export it again");
        if (pieces > 1) weld();
        return std::move(raw_);
    }

 private:
    /// Appended raw data is not XML: only what comes before it is parsed.
    void parse() {
        std::string_view xml = bytes_;
        const std::size_t element = bytes_.find("<AppendedData");
        if (element != std::string_view::npos) {
            const std::size_t begin = bytes_.find('_', std::min(bytes_.find('>', element), bytes_.size() - 1));
            if (begin == std::string_view::npos)
                fail(document_, "has AppendedData without its mark _", "export it again");
            xml = bytes_.substr(0, begin);
            appended_ = bytes_.substr(begin + 1);
        }
        if (std::count(xml.begin(), xml.end(), '<') > max_elements)
            fail(document_, "has more than " + std::to_string(max_elements) + " elements", "it is no mesh");
        std::string text(xml);
        if (element != std::string_view::npos) text += "</AppendedData></VTKFile>";
        const pugi::xml_parse_result result =
            document_.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
        if (!result)
            throw InputError{file_, line_at(result.offset),
                             std::string("is not well-formed XML: ") + result.description(),
                             "the file is cut off or broken: export it again"};
    }

    [[nodiscard]] std::size_t line_number(std::ptrdiff_t offset) const {
        const auto end =
            bytes_.begin() + std::clamp<std::ptrdiff_t>(offset, 0, static_cast<std::ptrdiff_t>(bytes_.size()));
        return static_cast<std::size_t>(std::count(bytes_.begin(), end, '\n')) + 1;
    }
    [[nodiscard]] std::string line_at(std::ptrdiff_t offset) const {
        return "line " + std::to_string(line_number(offset));
    }
    [[noreturn]] void fail(const pugi::xml_node& node, const std::string& problem, const std::string& remedy) const {
        throw InputError{file_, line_at(node.offset_debug()), problem, remedy};
    }

    std::int64_t whole(const pugi::xml_node& node, const char* name, std::int64_t otherwise) const {
        const pugi::xml_attribute attribute = node.attribute(name);
        if (!attribute) {
            if (otherwise < 0)
                fail(node, std::string("lacks the attribute ") + name, "the file is broken: export it again");
            return otherwise;
        }
        return Scanner(attribute.value(), file_, '\0', line_number(node.offset_debug())).integer(name, 0);
    }

    VtkType type_of(const pugi::xml_node& array) const {
        static constexpr const char* names[] = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                                "UInt32", "Int64", "UInt64", "Float32", "Float64"};
        for (int i = 0; i < 10; ++i)
            if (std::strcmp(array.attribute("type").value(), names[i]) == 0) return static_cast<VtkType>(i);
        fail(array,
             std::string("has values of the type '") + std::string(array.attribute("type").value()).substr(0, 40) + "'",
             "use numbers");
    }

    /// Values of a DataArray; `expected` of them, or as many as there are.
    template <class T>
    std::vector<T> values(const pugi::xml_node& array, std::size_t expected) {
        std::vector<T> out;
        const VtkType type = type_of(array);
        if (std::is_integral_v<T> && !is_integer(type))
            fail(array, "has no whole numbers", "the file is broken: export it again");
        const std::string format = array.attribute("format").value();
        if (format == "ascii") {
            const pugi::xml_node text = array.first_child();
            Scanner in(text.value(), file_, '\0', line_number(text ? text.offset_debug() : array.offset_debug()));
            while (!in.at_end() && out.size() <= max_values) {
                if constexpr (std::is_integral_v<T>)
                    out.push_back(in.integer("a whole number"));
                else
                    out.push_back(in.real("a number"));
            }
        } else if (format == "binary" || format == "appended") {
            const VtkFail broken = [&](const std::string& problem, const std::string& remedy) {
                fail(array, problem, remedy);
            };
            VtkEncoding encoding = encoding_;
            std::string_view text = array.child_value();
            if (format == "appended") {
                encoding.base64 = appended_base64_;
                const auto offset = static_cast<std::uint64_t>(whole(array, "offset", -1));
                if (offset >= appended_.size())
                    fail(array, "begins behind the end of the appended data", "the file is cut off");
                text = appended_.substr(offset);
            }
            const std::string bytes = decode_payload(text, encoding, broken);
            const std::size_t width = size_of(type), n = std::min(bytes.size() / width, max_values + 1);
            if (bytes.size() % width != 0) fail(array, "ends inside a value", "the file is broken: export it again");
            out.reserve(n);
            for (std::size_t i = 0; i < n; ++i) {
                if constexpr (std::is_integral_v<T>)
                    out.push_back(load_integer(bytes.data() + i * width, type, encoding.big_endian));
                else
                    out.push_back(load_real(bytes.data() + i * width, type, encoding.big_endian));
            }
        } else {
            fail(array, "has the unknown format '" + format.substr(0, 40) + "'", "use ascii, binary or appended");
        }
        if (out.size() > max_values) fail(array, "has too many values", "split the mesh");
        if (expected != any && out.size() != expected)
            fail(array, "has " + std::to_string(out.size()) + " values for " + std::to_string(expected),
                 "the file is cut off or broken: export it again");
        return out;
    }

    void read_piece(const pugi::xml_node& piece) {
        const auto points = static_cast<std::size_t>(whole(piece, "NumberOfPoints", -1));
        const auto cells = static_cast<std::size_t>(whole(piece, "NumberOfCells", -1));
        if (points > max_values / 3 || cells > max_values)
            fail(piece, "announces too many points or cells", "split the mesh");
        if (points == 0 && cells == 0) return;
        const std::size_t first_point = raw_.positions.size();
        if (first_point + points > max_values) fail(piece, "announces too many points", "split the mesh");

        const pugi::xml_node coordinates = piece.child("Points").child("DataArray");
        if (!coordinates) fail(piece, "has no Points", "the file is broken: export it again");
        if (whole(coordinates, "NumberOfComponents", 1) != 3)
            fail(coordinates, "needs 3 components", "export it in three dimensions");
        const auto x = values<double>(coordinates, 3 * points);
        for (std::size_t i = 0; i < points; ++i) {
            raw_.positions.emplace_back(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
            if (!raw_.positions.back().allFinite())
                fail(coordinates, "point " + std::to_string(i) + " is not finite",
                     "coordinates must be finite numbers");
        }

        const auto cell_array = [&](const char* name) {
            const pugi::xml_node array = piece.child("Cells").find_child_by_attribute("DataArray", "Name", name);
            if (!array)
                fail(piece, std::string("has no array ") + name + " in Cells", "the file is broken: export it again");
            return array;
        };
        const auto connectivity = values<std::int64_t>(cell_array("connectivity"), any);
        const auto ends = values<std::int64_t>(cell_array("offsets"), cells);
        const auto types = values<std::int64_t>(cell_array("types"), cells);
        append_cells(raw_, first_point, connectivity, ends, types, region(piece, cells),
                     [&](const std::string& problem, const std::string& remedy) { fail(piece, problem, remedy); });
    }

    std::vector<std::int64_t> region(const pugi::xml_node& piece, std::size_t cells) {
        std::vector<VtkCellData> names;
        std::vector<pugi::xml_node> arrays;
        for (const pugi::xml_node array : piece.child("CellData").children("DataArray")) {
            if (!is_integer(type_of(array)) || whole(array, "NumberOfComponents", 1) != 1) continue;
            names.push_back({array.attribute("Name").value(), {}});
            arrays.push_back(array);
        }
        const VtkCellData* chosen = find_region(names);
        if (!chosen) return {};
        return values<std::int64_t>(arrays[static_cast<std::size_t>(chosen - names.data())], cells);
    }

    /// Points at the same position in several pieces become one.
    void weld() {
        std::vector<std::int32_t> order(raw_.positions.size()), first(raw_.positions.size());
        std::iota(order.begin(), order.end(), 0);
        const auto key = [&](std::int32_t v) {
            const Vec3& p = raw_.positions[static_cast<std::size_t>(v)];
            return std::tuple(p[0], p[1], p[2], v);
        };
        std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) { return key(a) < key(b); });
        for (std::size_t i = 0; i < order.size(); ++i) {
            const auto v = static_cast<std::size_t>(order[i]);
            const bool same = i > 0 && raw_.positions[v] == raw_.positions[static_cast<std::size_t>(order[i - 1])];
            first[v] = same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
            raw_.repairs.welded_vertices += same ? 1 : 0;
        }
        for (auto& corners : raw_.corners)
            for (std::int32_t& v : corners) v = first[static_cast<std::size_t>(v)];
    }

    static constexpr std::size_t any = SIZE_MAX;
    static constexpr std::size_t max_values = std::size_t{1} << 27;

    std::string_view bytes_, appended_;
    std::string file_;
    pugi::xml_document document_;
    VtkEncoding encoding_;
    bool appended_base64_ = false;
    RawTets raw_;
};

}  // namespace

RawTets read_vtu(std::string_view bytes, const std::string& file) { return VtuReader(bytes, file).read(); }

}  // namespace tetfront
