// NRRD (teem.sourceforge.net/nrrd/format.html) and INRIMAGE-4 (a header of 256-byte blocks, then the voxels).

#include "engine/base/error.hpp"
#include "engine/material/voxel_image.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>

#include <zlib.h>

namespace tetfront {

namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 33;
constexpr const char* supported = "use NRRD with encoding raw or gzip, or INRIMAGE-4 (.inr, .inr.gz)";

/// A directory cannot be read, and opening a pipe waits for somebody to write.
void check_regular(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
        throw InputError(file.string(), "", "is no regular file", "name the file of an image");
}

std::string read_bytes(const std::filesystem::path& file) {
    check_regular(file);
    std::error_code error;
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(file.string(), "", "cannot be opened", "check the name and the permissions");
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error || size > most_bytes + (1U << 20))
        throw InputError(file.string(), "", "is larger than 8 GiB", "use a smaller image");
    std::string bytes(static_cast<std::size_t>(size), '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(size));
    if (in.bad()) throw InputError(file.string(), "", "cannot be read", "check the disk");
    bytes.resize(static_cast<std::size_t>(in.gcount()));
    return bytes;
}

/// Gunzips. More than `limit` bytes are an error, or are left out when only the beginning is asked for.
enum class Part { whole, beginning };
std::string inflate(const std::string& file, std::string_view packed, std::size_t limit, Part part = Part::whole) {
    z_stream stream{};
    ENSURE(inflateInit2(&stream, 15 + 32) == Z_OK, "zlib");  // 32: gzip or zlib header
    std::string out;
    std::vector<char> buffer(std::size_t{1} << 20);
    int status = Z_OK;
    std::size_t taken = 0;
    while (status == Z_OK) {
        if (stream.avail_in == 0) {
            const std::size_t piece = std::min(packed.size() - taken, buffer.size());
            stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + taken));
            stream.avail_in = static_cast<uInt>(piece);
            taken += piece;
        }
        stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
        stream.avail_out = static_cast<uInt>(buffer.size());
        const bool at_end = stream.avail_in == 0;
        status = ::inflate(&stream, Z_NO_FLUSH);
        out.append(buffer.data(), buffer.size() - stream.avail_out);
        if (out.size() > limit || (at_end && status == Z_OK && stream.avail_out == buffer.size())) break;
    }
    inflateEnd(&stream);
    if (part == Part::beginning) {
        out.resize(std::min(out.size(), limit));
        return out;
    }
    if (out.size() > limit)
        throw InputError(file, "voxel data", "unpacks to more bytes than the header says", "check the file");
    if (status != Z_STREAM_END)
        throw InputError(file, "voxel data", "ends early or is damaged (gzip)", "fetch or write the file again");
    return out;
}

std::string trim(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
    return first == std::string_view::npos ? std::string() : std::string(text.substr(first, last - first + 1));
}

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

/// Header fields with their names in lower case.
class Fields {
 public:
    explicit Fields(std::string file) : file_(std::move(file)) {}

    void set(std::string_view key, std::string_view value) { values_[lower(trim(key))] = trim(value); }
    [[nodiscard]] std::optional<std::string> find(const std::string& key) const {
        const auto i = values_.find(key);
        return i == values_.end() ? std::nullopt : std::optional(i->second);
    }
    [[nodiscard]] std::string need(const std::string& key) const {
        if (const auto value = find(key)) return *value;
        throw InputError(file_, "header field '" + key + "'", "is missing", supported);
    }
    [[noreturn]] void refuse(const std::string& key, const std::string& allowed) const {
        throw InputError(file_, "header field '" + key + "'", "is '" + find(key).value_or("") + "'", allowed);
    }
    [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t count) const {
        std::istringstream in(need(key));
        std::vector<double> values;
        for (double value = 0; in >> value;) values.push_back(value);
        if (values.size() != count || !in.eof()) refuse(key, "give " + std::to_string(count) + " numbers");
        return values;
    }
    [[nodiscard]] int extent(const std::string& key, double value) const {
        if (!(value >= 1 && value <= 65536) || value != std::floor(value))
            refuse(key, "use whole numbers from 1 to 65536");
        return static_cast<int>(value);
    }
    [[nodiscard]] const std::string& file() const { return file_; }

 private:
    std::string file_;
    std::map<std::string, std::string> values_;
};

/// Puts `bytes` into the image, in this machine's byte order.
void take_voxels(VoxelImage& image, std::string_view bytes, std::endian order) {
    const std::size_t width = size_of(image.type);
    const std::size_t count = static_cast<std::size_t>(image.size[0]) * static_cast<std::size_t>(image.size[1]) *
                              static_cast<std::size_t>(image.size[2]);
    if (count * width > most_bytes)
        throw InputError(image.source, "voxel data", "would need more than 8 GiB", "use a smaller image");
    if (bytes.size() < count * width) {
        throw InputError(
            image.source, "voxel data",
            "ends after " + std::to_string(bytes.size()) + " of " + std::to_string(count * width) + " bytes",
            "fetch or write the file again");
    }
    image.data.resize(count * width);
    std::memcpy(image.data.data(), bytes.data(), count * width);
    if (order == std::endian::native || width == 1) return;
    for (std::size_t i = 0; i < count; ++i) {
        std::reverse(image.data.begin() + static_cast<std::ptrdiff_t>(i * width),
                     image.data.begin() + static_cast<std::ptrdiff_t>((i + 1) * width));
    }
}

VoxelImage::Type nrrd_type(const Fields& fields) {
    using Type = VoxelImage::Type;
    static const std::map<std::string, Type> types = {{"signed char", Type::int8},      {"int8", Type::int8},
                                                      {"int8_t", Type::int8},           {"uchar", Type::uint8},
                                                      {"unsigned char", Type::uint8},   {"uint8", Type::uint8},
                                                      {"uint8_t", Type::uint8},         {"short", Type::int16},
                                                      {"int16", Type::int16},           {"int16_t", Type::int16},
                                                      {"signed short", Type::int16},    {"ushort", Type::uint16},
                                                      {"unsigned short", Type::uint16}, {"uint16", Type::uint16},
                                                      {"uint16_t", Type::uint16},       {"int", Type::int32},
                                                      {"signed int", Type::int32},      {"int32", Type::int32},
                                                      {"int32_t", Type::int32},         {"uint", Type::uint32},
                                                      {"unsigned int", Type::uint32},   {"uint32", Type::uint32},
                                                      {"uint32_t", Type::uint32},       {"longlong", Type::int64},
                                                      {"int64", Type::int64},           {"int64_t", Type::int64},
                                                      {"ulonglong", Type::uint64},      {"uint64", Type::uint64},
                                                      {"uint64_t", Type::uint64},       {"float", Type::float32},
                                                      {"double", Type::float64}};
    const auto i = types.find(lower(fields.need("type")));
    if (i == types.end()) fields.refuse("type", "use an integer type of 8 to 64 bits, float or double");
    return i->second;
}

/// "(a,b,c)" three times.
Mat3 nrrd_vectors(const Fields& fields, const std::string& key, int count) {
    std::string text = fields.need(key);
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
    std::istringstream in(text);
    Mat3 columns = Mat3::Zero();
    for (int j = 0; j < count; ++j)
        for (int i = 0; i < 3; ++i)
            if (!(in >> columns(i, j))) fields.refuse(key, "give vectors of three numbers: (x,y,z)");
    return columns;
}

VoxelImage read_nrrd(const std::filesystem::path& file, const std::string& bytes) {
    Fields fields(file.string());
    std::size_t at = bytes.find('\n');
    while (at != std::string::npos) {
        const std::size_t begin = at + 1, end = bytes.find('\n', begin);
        if (end == std::string::npos) {
            at = bytes.size();
            break;
        }
        const std::string line = trim(std::string_view(bytes).substr(begin, end - begin));
        at = end;
        if (line.empty()) break;  // the data follow
        if (line[0] == '#') continue;
        const std::size_t colon = line.find(':');
        if (colon == std::string::npos) {
            throw InputError(file.string(), "header line '" + line.substr(0, 40) + "'", "has no colon", supported);
        }
        if (colon + 1 < line.size() && line[colon + 1] == '=') continue;  // free key:=value pairs
        fields.set(line.substr(0, colon), line.substr(colon + 1));
    }
    if (fields.need("dimension") != "3") fields.refuse("dimension", "use an image with three dimensions");

    VoxelImage image;
    image.source = file.string();
    image.type = nrrd_type(fields);
    const auto sizes = fields.numbers("sizes", 3);
    for (std::size_t i = 0; i < 3; ++i) image.size[i] = fields.extent("sizes", sizes[i]);
    Mat3 directions = Mat3::Identity();
    Vec3 origin = Vec3::Zero();
    if (fields.find("space directions")) {
        directions = nrrd_vectors(fields, "space directions", 3);
    } else if (fields.find("spacings")) {
        const auto spacings = fields.numbers("spacings", 3);
        directions = Vec3(spacings[0], spacings[1], spacings[2]).asDiagonal();
    }
    if (fields.find("space origin")) origin = nrrd_vectors(fields, "space origin", 1).col(0);
    image.place(origin, directions);

    for (const char* skip : {"byte skip", "byteskip", "line skip", "lineskip"}) {
        if (const auto value = fields.find(skip); value && *value != "0")
            fields.refuse(skip, "skipping is not supported");
    }
    auto order = std::endian::native;
    if (size_of(image.type) > 1) {
        const std::string endian = lower(fields.need("endian"));
        if (endian != "little" && endian != "big") fields.refuse("endian", "use little or big");
        order = endian == "little" ? std::endian::little : std::endian::big;
    }
    auto data_file = fields.find("data file");
    if (!data_file) data_file = fields.find("datafile");
    std::string detached;
    std::string_view voxels = std::string_view(bytes).substr(std::min(at + 1, bytes.size()));
    if (data_file) {
        detached = read_bytes(file.parent_path() / *data_file);
        voxels = detached;
    }
    const std::string encoding = lower(fields.need("encoding"));
    std::string unpacked;
    if (encoding == "gzip" || encoding == "gz") {
        std::size_t expected = size_of(image.type);
        for (int n : image.size) expected *= static_cast<std::size_t>(n);
        unpacked = inflate(image.source, voxels, std::min(expected, most_bytes));
        voxels = unpacked;
    } else if (encoding != "raw") {
        fields.refuse("encoding", supported);
    }
    take_voxels(image, voxels, order);
    return image;
}

/// packed: the file, when it is gzipped and `bytes` holds no more than its beginning.
VoxelImage read_inr(const std::filesystem::path& file, std::string bytes, std::string_view packed) {
    const std::size_t end = bytes.find("##}");
    if (end == std::string::npos) throw InputError(file.string(), "header", "has no end '##}'", supported);
    const std::size_t header_size = (end + 3 + 255) / 256 * 256;
    Fields fields(file.string());
    std::istringstream header(bytes.substr(0, end));
    for (std::string line; std::getline(header, line);) {
        const std::size_t equals = line.find('=');
        if (!line.empty() && line[0] != '#' && equals != std::string::npos)
            fields.set(line.substr(0, equals), line.substr(equals + 1));
    }
    VoxelImage image;
    image.source = file.string();
    const std::array<const char*, 3> dimensions = {"xdim", "ydim", "zdim"}, spacings = {"vx", "vy", "vz"},
                                     translations = {"tx", "ty", "tz"};
    Vec3 origin = Vec3::Zero(), spacing = Vec3::Ones();
    for (std::size_t i = 0; i < 3; ++i) {
        image.size[i] = fields.extent(dimensions[i], fields.numbers(dimensions[i], 1)[0]);
        if (fields.find(spacings[i])) spacing[static_cast<int>(i)] = fields.numbers(spacings[i], 1)[0];
        if (fields.find(translations[i])) origin[static_cast<int>(i)] = fields.numbers(translations[i], 1)[0];
    }
    if (const auto v = fields.find("vdim"); v && *v != "1")
        fields.refuse("vdim", "use an image with one value per voxel");
    image.place(origin, spacing.asDiagonal());

    std::istringstream pixel(fields.need("pixsize"));
    int bits = 0;
    pixel >> bits;
    const std::string type = lower(fields.need("type"));
    using Type = VoxelImage::Type;
    static const std::map<std::pair<std::string, int>, Type> types = {
        {{"unsigned fixed", 8}, Type::uint8},   {{"unsigned fixed", 16}, Type::uint16},
        {{"unsigned fixed", 32}, Type::uint32}, {{"signed fixed", 8}, Type::int8},
        {{"signed fixed", 16}, Type::int16},    {{"signed fixed", 32}, Type::int32},
        {{"float", 32}, Type::float32},         {{"float", 64}, Type::float64}};
    const auto found = types.find({type, bits});
    if (found == types.end()) fields.refuse("type", "use unsigned fixed or signed fixed of 8, 16, 32 bits, or float");
    image.type = found->second;
    auto order = std::endian::little;
    if (const auto cpu = fields.find("cpu")) {
        const std::string name = lower(*cpu);
        if (name == "sun" || name == "sgi") {
            order = std::endian::big;
        } else if (name != "decm" && name != "alpha" && name != "pc") {
            fields.refuse("cpu", "use decm, alpha, pc (little-endian), sun or sgi (big-endian)");
        }
    }
    if (!packed.empty()) {
        std::size_t size = header_size + size_of(image.type);
        for (int n : image.size) size = header_size + (size - header_size) * static_cast<std::size_t>(n);
        bytes = inflate(image.source, packed, std::min(size, most_bytes), Part::beginning);
    }
    take_voxels(image, std::string_view(bytes).substr(std::min(header_size, bytes.size())), order);
    return image;
}

}  // namespace

VoxelImage read_voxel_image(const std::filesystem::path& file) {
    check_regular(file);
    std::string head(16, '\0');
    std::ifstream(file, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
    // Before gigabytes of something else are read. What cannot be opened is said below.
    if (head[0] != '\0' && !head.starts_with("\x1f\x8b") && !head.starts_with("NRRD000") && !head.starts_with("#INRIMAGE-4#{"))
        throw InputError(file.string(), "", "is not an image that can be read", supported);
    std::string bytes = read_bytes(file);
    std::string packed;
    if (bytes.starts_with("\x1f\x8b")) {
        packed = std::move(bytes);
        bytes = inflate(file.string(), packed, std::size_t{1} << 16, Part::beginning);  // the header says how much to expect
        if (bytes.starts_with("NRRD000")) bytes = inflate(file.string(), packed, most_bytes);
    }
    if (bytes.starts_with("NRRD000")) return read_nrrd(file, bytes);
    if (bytes.starts_with("#INRIMAGE-4#{")) return read_inr(file, std::move(bytes), packed);
    throw InputError(file.string(), "", "is not an image that can be read", supported);
}

}  // namespace tetfront
