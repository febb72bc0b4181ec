#pragma once
// Writes a small tet mesh in every variant of every format that read_tet_mesh() knows: for its tests, and as seeds of
// the fuzzers.

#include "engine/mesh/tet_mesh.hpp"

#include <bit>
#include <cstring>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <zlib.h>

namespace tetfront::tet_files {

/// Two cubes in regions 7 and 9; the third tet is inverted, and vertex 0 belongs to no tet.
inline TetMesh sample() {
    TetMesh mesh = box_mesh({0, 0, 0}, {2, 1, 1}, {2, 1, 1});
    for (TetId t : ids<TetId>(mesh.corners.size())) mesh.region.push_back(t.index() < 6 ? 7 : 9);
    mesh.positions.insert(mesh.positions.begin(), Vec3(9, 9, 9));
    for (auto& corners : mesh.corners)
        for (VertexId& v : corners) ++v.value;
    std::swap(mesh.corners[TetId{2}][0], mesh.corners[TetId{2}][1]);
    return mesh;
}

/// Binary numbers one after another.
class Bytes {
 public:
    explicit Bytes(bool big_endian = false) : big_endian_(big_endian) {}
    template <class T>
    Bytes& put(T value) {
        char bytes[sizeof(T)];
        std::memcpy(bytes, &value, sizeof(T));
        for (std::size_t i = 0; i < sizeof(T); ++i)
            text += bytes[big_endian_ == (std::endian::native == std::endian::big) ? i : sizeof(T) - 1 - i];
        return *this;
    }
    Bytes& put(const Vec3& x) { return put(x[0]).put(x[1]).put(x[2]); }
    std::string text;

 private:
    bool big_endian_;
};

inline std::string gmsh1(const TetMesh& mesh) {
    std::ostringstream out;
    out.precision(17);
    out << "$NOD\n" << mesh.positions.size() << '\n';
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        out << 10 + 2 * v << ' ' << mesh.positions[VertexId(static_cast<std::int64_t>(v))].transpose() << '\n';
    out << "$ENDNOD\n$ELM\n" << mesh.corners.size() + 1 << "\n1 2 3 3 3 10 12 14\n";
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        out << 2 + t.value << " 4 " << mesh.region[t] << " 1 4";
        for (VertexId v : mesh.corners[t]) out << ' ' << 10 + 2 * v.value;
        out << '\n';
    }
    out << "$ENDELM\n";
    return out.str();
}

inline std::string gmsh2_text(const TetMesh& mesh) {
    std::ostringstream out;
    out.precision(17);
    out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 7 \"liver\"\n$EndPhysicalNames\n$Nodes\n"
        << mesh.positions.size() << '\n';
    for (VertexId v : ids<VertexId>(mesh.positions.size()))
        out << 10 + 2 * v.value << ' ' << mesh.positions[v].transpose() << '\n';
    out << "$EndNodes\n$Elements\n" << mesh.corners.size() + 1 << "\n1 2 2 3 3 10 12 14\n";
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        out << 2 + t.value << " 4 2 " << mesh.region[t] << " 1";
        for (VertexId v : mesh.corners[t]) out << ' ' << 10 + 2 * v.value;
        out << '\n';
    }
    out << "$EndElements\n";
    return out.str();
}

inline std::string gmsh2_binary(const TetMesh& mesh, bool big_endian) {
    Bytes one(big_endian), nodes(big_endian), elements(big_endian);
    one.put(std::int32_t{1});
    for (VertexId v : ids<VertexId>(mesh.positions.size())) nodes.put(10 + 2 * v.value).put(mesh.positions[v]);
    for (std::int32_t n : {2, 1, 1, 1, 3, 10, 12, 14}) elements.put(n);  // a triangle with one tag
    elements.put(std::int32_t{4}).put(static_cast<std::int32_t>(mesh.corners.size())).put(std::int32_t{2});
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        elements.put(2 + t.value).put(mesh.region[t]).put(std::int32_t{1});
        for (VertexId v : mesh.corners[t]) elements.put(10 + 2 * v.value);
    }
    return "$MeshFormat\n2.2 1 8\n" + one.text + "\n$EndMeshFormat\n$Nodes\n" + std::to_string(mesh.positions.size()) +
           "\n" + nodes.text + "\n$EndNodes\n$Elements\n" + std::to_string(mesh.corners.size() + 1) + "\n" +
           elements.text + "\n$EndElements\n";
}

/// Volumes 1 and 2 carry the regions of the first and the last tet; the mesh's other tets must follow them.
inline std::string gmsh4_text(const TetMesh& mesh) {
    std::ostringstream out;
    out.precision(17);
    const auto first = mesh.region.front(), last = mesh.region.back();
    std::vector<TetId> block[2];
    for (TetId t : ids<TetId>(mesh.corners.size())) block[mesh.region[t] == first ? 0 : 1].push_back(t);
    out << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n1 0 1 2\n1 0 0 0 1 5\n1 0 0 0 1 1 1 0 0\n"
        << "1 0 0 0 1 1 1 1 " << first << " 1 1\n2 1 0 0 2 1 1 2 " << last << " 4 0\n$EndEntities\n$Nodes\n2 "
        << mesh.positions.size() << " 10 " << 10 + 2 * mesh.positions.size() << "\n2 1 1 1\n10\n"
        << mesh.positions.front().transpose() << " 0.5 0.5\n3 1 0 " << mesh.positions.size() - 1 << '\n';
    for (std::size_t v = 1; v < mesh.positions.size(); ++v) out << 10 + 2 * v << '\n';
    for (std::size_t v = 1; v < mesh.positions.size(); ++v)
        out << mesh.positions[VertexId(static_cast<std::int64_t>(v))].transpose() << '\n';
    out << "$EndNodes\n$Elements\n3 " << mesh.corners.size() + 1 << " 1 100\n2 1 2 1\n1 10 12 14\n";
    for (int b = 0; b < 2; ++b) {
        out << "3 " << b + 1 << " 4 " << block[b].size() << '\n';
        for (TetId t : block[b]) {
            out << 2 + t.value;
            for (VertexId v : mesh.corners[t]) out << ' ' << 10 + 2 * v.value;
            out << '\n';
        }
    }
    out << "$EndElements\n";
    return out.str();
}

inline std::string gmsh4_binary(const TetMesh& mesh) {
    using Large = std::int64_t;
    using Small = std::int32_t;
    const auto first = mesh.region.front(), last = mesh.region.back();
    std::vector<TetId> block[2];
    for (TetId t : ids<TetId>(mesh.corners.size())) block[mesh.region[t] == first ? 0 : 1].push_back(t);
    Bytes one, entities, nodes, elements;
    one.put(Small{1});
    for (Large n : {0, 0, 0, 2}) entities.put(n);
    for (Small tag : {1, 2}) {
        entities.put(tag);
        for (int i = 0; i < 6; ++i) entities.put(0.5);
        entities.put(Large{1}).put(tag == 1 ? first : last).put(Large{0});
    }
    const Large n = static_cast<Large>(mesh.positions.size());
    nodes.put(Large{1}).put(n).put(Large{10}).put(10 + 2 * n).put(Small{3}).put(Small{1}).put(Small{0}).put(n);
    for (Large v = 0; v < n; ++v) nodes.put(10 + 2 * v);
    for (const Vec3& x : mesh.positions) nodes.put(x);
    elements.put(Large{2}).put(static_cast<Large>(mesh.corners.size())).put(Large{1}).put(Large{100});
    for (Small b : {0, 1}) {
        elements.put(Small{3}).put(b + 1).put(Small{4}).put(static_cast<Large>(block[b].size()));
        for (TetId t : block[b]) {
            elements.put(Large{2} + t.value);
            for (VertexId v : mesh.corners[t]) elements.put(Large{10} + 2 * v.value);
        }
    }
    return "$MeshFormat\n4.1 1 8\n" + one.text + "\n$EndMeshFormat\n$Entities\n" + entities.text +
           "\n$EndEntities\n$Nodes\n" + nodes.text + "\n$EndNodes\n$Elements\n" + elements.text + "\n$EndElements\n";
}

inline std::string medit(const TetMesh& mesh) {
    std::ostringstream out;
    out.precision(17);
    out << "MeshVersionFormatted 2\n# a comment\nDimension\n3\nVertices\n" << mesh.positions.size() << '\n';
    for (const Vec3& x : mesh.positions) out << x.transpose() << " 0\n";
    out << "Normals 1\n0 0 1.5e0\nTriangles 1\n1 2 3 4\nTetrahedra\n" << mesh.corners.size() << '\n';
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        for (VertexId v : mesh.corners[t]) out << v.value + 1 << ' ';
        out << mesh.region[t] << '\n';
    }
    out << "End\n";
    return out.str();
}

inline std::pair<std::string, std::string> tetgen(const TetMesh& mesh, int first) {
    std::ostringstream node, ele;
    node.precision(17);
    node << "# points\n" << mesh.positions.size() << " 3 1 1\n";
    for (VertexId v : ids<VertexId>(mesh.positions.size()))
        node << v.value + first << ' ' << mesh.positions[v].transpose() << " 0.25 1 # end\n";
    ele << mesh.corners.size() << " 4 1\n";
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        ele << t.value + first;
        for (VertexId v : mesh.corners[t]) ele << ' ' << v.value + first;
        ele << ' ' << mesh.region[t] << '\n';
    }
    return {node.str(), ele.str()};
}

/// A triangle, then the tets.
struct VtkCells {
    std::vector<std::int64_t> connectivity, ends, types, region;
};
inline VtkCells vtk_cells(const TetMesh& mesh) {
    VtkCells cells{{0, 1, 2}, {3}, {5}, {0}};
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        for (VertexId v : mesh.corners[t]) cells.connectivity.push_back(v.value);
        cells.ends.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
        cells.types.push_back(10);
        cells.region.push_back(mesh.region[t]);
    }
    return cells;
}

/// version: "3.0" or "5.1".
inline std::string vtk_legacy(const TetMesh& mesh, bool binary, const std::string& version) {
    const VtkCells cells = vtk_cells(mesh);
    const bool old = version[0] < '5';
    std::string out = "# vtk DataFile Version " + version + "\na title\n" + (binary ? "BINARY" : "ASCII") +
                      "\nDATASET UNSTRUCTURED_GRID\n";
    const auto numbers = [&](const auto& values, auto convert) {
        Bytes bytes(true);
        std::ostringstream text;
        text.precision(17);
        for (const auto& value : values) {
            if (binary)
                bytes.put(convert(value));
            else
                text << +convert(value) << ' ';
        }
        out += (binary ? bytes.text : text.str()) + "\n";
    };
    const auto as_int = [](auto x) { return static_cast<std::int32_t>(x); };
    const auto as_long = [](auto x) { return static_cast<std::int64_t>(x); };
    std::vector<double> coordinates;
    for (const Vec3& x : mesh.positions) coordinates.insert(coordinates.end(), {x[0], x[1], x[2]});
    out += "POINTS " + std::to_string(mesh.positions.size()) + " double\n";
    numbers(coordinates, [](double x) { return x; });
    const std::string n = std::to_string(cells.types.size());
    if (old) {
        std::vector<std::int64_t> list;
        for (std::size_t c = 0, begin = 0; c < cells.types.size(); begin = static_cast<std::size_t>(cells.ends[c++])) {
            list.push_back(cells.ends[c] - static_cast<std::int64_t>(begin));
            for (auto i = begin; i < static_cast<std::size_t>(cells.ends[c]); ++i)
                list.push_back(cells.connectivity[i]);
        }
        out += "CELLS " + n + " " + std::to_string(list.size()) + "\n";
        numbers(list, as_int);
    } else {
        std::vector<std::int64_t> offsets = cells.ends;
        offsets.insert(offsets.begin(), 0);
        out += "CELLS " + std::to_string(offsets.size()) + " " + std::to_string(cells.connectivity.size()) +
               "\nOFFSETS vtktypeint64\n";
        numbers(offsets, as_long);
        out += "CONNECTIVITY vtktypeint64\n";
        numbers(cells.connectivity, as_long);
    }
    out += "CELL_TYPES " + n + "\n";
    numbers(cells.types, as_int);
    out += "POINT_DATA " + std::to_string(mesh.positions.size()) + "\nVECTORS velocity double\n";
    numbers(coordinates, [](double x) { return x; });
    out += "METADATA\nINFORMATION 0\n\nCELL_DATA " + n + "\nSCALARS quality double\nLOOKUP_TABLE default\n";
    numbers(cells.region, [](std::int64_t x) { return 0.5 * static_cast<double>(x); });
    out += "FIELD FieldData 1\nmaterial 1 " + n + " int\n";
    numbers(cells.region, as_int);
    return out;
}

inline std::string base64(const std::string& bytes) {
    static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned value = 0;
        for (std::size_t k = 0; k < 3; ++k)
            value = value << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[value >> (18 - 6 * k) & 63];
    }
    return out;
}

enum class VtuFormat { ascii, base64, appended_base64, appended_raw };
struct VtuVariant {
    VtuFormat format = VtuFormat::ascii;
    bool zlib = false, big_endian = false, wide_header = false;
};

/// In one piece, or in two that share the points of a face.
inline std::string vtu(const TetMesh& mesh, VtuVariant variant, int pieces = 1) {
    std::string appended;
    const auto header_number = [&](Bytes& bytes, std::size_t n) {
        if (variant.wide_header)
            bytes.put(static_cast<std::uint64_t>(n));
        else
            bytes.put(static_cast<std::uint32_t>(n));
    };
    const auto payload = [&](const std::string& data, bool text) {
        Bytes header(variant.big_endian);
        std::string body = data;
        if (variant.zlib) {
            const std::size_t block = 64, blocks = (data.size() + block - 1) / block;
            header_number(header, blocks), header_number(header, block), header_number(header, data.size() % block);
            body.clear();
            for (std::size_t b = 0; b < blocks; ++b) {
                const std::string part = data.substr(b * block, block);
                uLongf size = compressBound(part.size());
                std::string packed(size, '\0');
                compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(part.data()),
                         part.size());
                header_number(header, size);
                body += packed.substr(0, size);
            }
            return text ? base64(header.text) + base64(body) : header.text + body;
        }
        header_number(header, data.size());
        return text ? base64(header.text + body) : header.text + body;
    };
    const auto array = [&](const std::string& type, const std::string& name, int components, const auto& values,
                           auto convert) {
        std::string out = "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                          std::to_string(components) + "\" format=";
        if (variant.format == VtuFormat::ascii) {
            std::ostringstream text;
            text.precision(17);
            for (const auto& value : values) text << +convert(value) << '\n';
            return out + "\"ascii\">\n" + text.str() + "</DataArray>\n";
        }
        Bytes data(variant.big_endian);
        for (const auto& value : values) data.put(convert(value));
        if (variant.format == VtuFormat::base64)
            return out + "\"binary\">\n  " + payload(data.text, true) + "\n</DataArray>\n";
        out += "\"appended\" offset=\"" + std::to_string(appended.size()) + "\"/>\n";
        appended += payload(data.text, variant.format == VtuFormat::appended_base64);
        return out;
    };
    std::string body;
    for (int p = 0; p < pieces; ++p) {
        TetMesh part;
        part.positions = mesh.positions;
        for (TetId t : ids<TetId>(mesh.corners.size()))
            if (pieces == 1 || static_cast<int>(t.index() % static_cast<std::size_t>(pieces)) == p) {
                part.corners.push_back(mesh.corners[t]);
                part.region.push_back(mesh.region[t]);
            }
        const VtkCells cells = vtk_cells(part);
        std::vector<double> coordinates;
        for (const Vec3& x : part.positions) coordinates.insert(coordinates.end(), {x[0], x[1], x[2]});
        body += "<Piece NumberOfPoints=\"" + std::to_string(part.positions.size()) + "\" NumberOfCells=\"" +
                std::to_string(cells.types.size()) + "\">\n<PointData></PointData>\n<CellData>\n";
        body += array("Float64", "quality", 1, cells.region, [](std::int64_t x) { return static_cast<double>(x); });
        body +=
            array("Int32", "MaterialIDs", 1, cells.region, [](std::int64_t x) { return static_cast<std::int32_t>(x); });
        body += "</CellData>\n<Points>\n" + array("Float64", "Points", 3, coordinates, [](double x) { return x; }) +
                "</Points>\n<Cells>\n";
        body += array("Int64", "connectivity", 1, cells.connectivity, [](std::int64_t x) { return x; });
        body += array("Int64", "offsets", 1, cells.ends, [](std::int64_t x) { return x; });
        body += array("UInt8", "types", 1, cells.types, [](std::int64_t x) { return static_cast<std::uint8_t>(x); });
        body += "</Cells>\n</Piece>\n";
    }
    std::string out = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"";
    out += variant.big_endian ? "BigEndian\"" : "LittleEndian\"";
    out += variant.wide_header ? " header_type=\"UInt64\"" : " header_type=\"UInt32\"";
    if (variant.zlib) out += " compressor=\"vtkZLibDataCompressor\"";
    out += ">\n<UnstructuredGrid>\n" + body + "</UnstructuredGrid>\n";
    if (!appended.empty())
        out += std::string("<AppendedData encoding=\"") +
               (variant.format == VtuFormat::appended_raw ? "raw" : "base64") + "\">\n_" + appended +
               "\n</AppendedData>\n";
    return out + "</VTKFile>\n";
}

/// File name and content of every variant; TetGen's pair is not among them.
inline std::vector<std::pair<std::string, std::string>> all(const TetMesh& mesh) {
    std::vector<std::pair<std::string, std::string>> files = {{"gmsh1.msh", gmsh1(mesh)},
                                                              {"gmsh2.msh", gmsh2_text(mesh)},
                                                              {"gmsh2_little.msh", gmsh2_binary(mesh, false)},
                                                              {"gmsh2_big.msh", gmsh2_binary(mesh, true)},
                                                              {"gmsh4.msh", gmsh4_text(mesh)},
                                                              {"gmsh4_binary.msh", gmsh4_binary(mesh)},
                                                              {"medit.mesh", medit(mesh)}};
    for (const char* version : {"3.0", "5.1"})
        for (bool binary : {false, true})
            files.emplace_back(std::string("vtk") + version[0] + (binary ? "_binary" : "_text") + ".vtk",
                               vtk_legacy(mesh, binary, version));
    for (VtuFormat format : {VtuFormat::ascii, VtuFormat::base64, VtuFormat::appended_base64, VtuFormat::appended_raw})
        for (bool zlib : {false, true})
            for (bool big_endian : {false, true})
                for (bool wide_header : {false, true}) {
                    if (format == VtuFormat::ascii && (zlib || big_endian || wide_header)) continue;
                    files.emplace_back("vtu" + std::to_string(static_cast<int>(format)) + (zlib ? "_zlib" : "") +
                                           (big_endian ? "_big" : "") + (wide_header ? "_wide" : "") + ".vtu",
                                       vtu(mesh, {format, zlib, big_endian, wide_header}));
                }
    return files;
}

}  // namespace tetfront::tet_files
