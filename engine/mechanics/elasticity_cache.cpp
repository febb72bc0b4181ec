#include "engine/mechanics/elasticity_cache.hpp"

#include "engine/base/bytes.hpp"
#include "engine/base/hash.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <sstream>
#include <system_error>
#include <type_traits>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tetfront {

namespace {

/// Bump whenever the layout below or any result changes.
constexpr std::uint64_t format_version = 3;
constexpr std::array<char, 8> magic = {'t', 'e', 't', 'f', 'r', 'C', '\r', '\n'};

struct Header {
    std::array<char, 8> magic;
    std::uint64_t version, key, payload_bytes, checksum;
};
static_assert(sizeof(Header) == 40);
static_assert(std::is_trivially_copyable_v<LevelReport> && std::is_trivially_copyable_v<Sym6>);

std::uint64_t key_of(const TetTree& tree, const StiffnessFunction& function, const EstimationSettings& settings) {
    Hash hash;
    hash.add(format_version).add(tree.depth()).add(tree.root_count());
    hash.add_bytes(tree.rest().data(), tree.vertex_count(0) * sizeof(Vec3));
    for (TetId t : tree.level(0)) hash.add_bytes(tree.corners(t).data(), sizeof tree.corners(t));
    function.hash_into(hash);
    hash.add(settings.problem).add(settings.sampling.has_value());
    if (settings.sampling) {
        hash.add_range(settings.sampling->alphas);
        hash.add(settings.sampling->relative_tolerance).add(settings.sampling->stress_tolerance);
    }
    return hash.value();
}

/// Equal neighbours are stored once: a uniform object is tiny.
class Writer : public ByteWriter {
 public:
    template <class T>
    void pooled(const PooledPerTet<T>& v) {
        put_range(v.values());
        runs(v.numbers());
    }
    /// Consecutive equal values once, with their number.
    template <class T>
    void runs(const std::vector<T>& v) {
        std::vector<T> values;
        std::vector<std::uint32_t> lengths;
        for (const T& x : v) {
            if (values.empty() || !(values.back() == x)) {
                values.push_back(x);
                lengths.push_back(0);
            }
            ++lengths.back();
        }
        put_range(values);
        put_range(lengths);
    }
};

class Reader : public ByteReader {
 public:
    using ByteReader::ByteReader;

    template <class T>
    bool pooled(PooledPerTet<T>& v, std::size_t most) {
        std::vector<T> values;
        std::vector<std::uint32_t> numbers;
        if (!get_range(values) || !runs(numbers, most)) return false;
        if (std::any_of(numbers.begin(), numbers.end(), [&](std::uint32_t n) { return n >= values.size(); })) return false;
        v = {std::move(values), std::move(numbers)};
        return true;
    }
    template <class T>
    bool runs(std::vector<T>& v, std::size_t most) {
        std::vector<T> values;
        std::vector<std::uint32_t> lengths;
        if (!get_range(values) || !get_range(lengths) || values.size() != lengths.size()) return false;
        std::size_t total = 0;
        for (const std::uint32_t n : lengths) total += n;
        if (total > most) return false;
        if (total == values.size()) {
            v = std::move(values);
            return true;
        }
        v.clear();
        v.reserve(total);
        for (std::size_t i = 0; i < values.size(); ++i) v.insert(v.end(), lengths[i], values[i]);
        return true;
    }
};

std::string pack(const CoarseMaterials& m) {
    Writer w;
    w.pooled(m.matrices.elasticity);
    w.pooled(m.matrices.bracket);
    w.pooled(m.matrices.valid_range);
    w.runs(m.matrices.mass_damping);
    w.runs(m.matrices.stiffness_damping);
    w.put_range(m.matrices.report);
    w.runs(m.density);
    return w.bytes();
}

std::optional<CoarseMaterials> unpack(std::string_view payload, std::size_t tets) {
    CoarseMaterials m;
    Reader r(payload);
    const auto complete = [&](const auto& v) { return v.empty() || v.size() == tets; };
    const bool read = r.pooled(m.matrices.elasticity, tets) && r.pooled(m.matrices.bracket, tets) &&
                      r.pooled(m.matrices.valid_range, tets) && r.runs(m.matrices.mass_damping, tets) &&
                      r.runs(m.matrices.stiffness_damping, tets) && r.get_range(m.matrices.report) &&
                      r.runs(m.density, tets) && r.done();
    if (!read || m.matrices.elasticity.size() != tets || m.density.size() != tets || !complete(m.matrices.bracket) ||
        !complete(m.matrices.valid_range) || !complete(m.matrices.mass_damping) ||
        !complete(m.matrices.stiffness_damping))
        return std::nullopt;
    m.from_cache = true;
    return m;
}

/// A file descriptor that closes itself.
class File {
 public:
    File(const std::filesystem::path& path, int flags) : descriptor_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {}
    ~File() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    [[nodiscard]] bool open() const { return descriptor_ >= 0; }
    [[nodiscard]] bool sync() const { return ::fsync(descriptor_) == 0; }
    [[nodiscard]] bool write(std::string_view bytes) const {
        while (!bytes.empty()) {
            const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
            if (n < 0 && errno != EINTR) return false;
            if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
        }
        return true;
    }
    /// Everything from here to the end.
    [[nodiscard]] std::optional<std::string> read_all() const {
        struct stat status {};
        if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
        std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
        std::size_t done = 0;
        while (done < bytes.size()) {
            const ssize_t n = ::read(descriptor_, bytes.data() + done, bytes.size() - done);
            if (n < 0 && errno != EINTR) return std::nullopt;
            if (n == 0) break;
            if (n > 0) done += static_cast<std::size_t>(n);
        }
        bytes.resize(done);
        return bytes;
    }

 private:
    int descriptor_;
};

/// What was stored, or why it cannot be used; neither when there is no such file.
struct Found {
    std::optional<CoarseMaterials> materials;
    std::string problem;
};

Found load(const std::filesystem::path& path, std::uint64_t key, std::size_t tets) {
    const File file(path, O_RDONLY | O_NONBLOCK);  // a pipe of that name would make us wait for a writer
    if (!file.open()) return {{}, errno == ENOENT ? "" : std::string("cannot be opened: ") + std::strerror(errno)};
    const std::optional<std::string> bytes = file.read_all();
    if (!bytes) return {{}, std::string("cannot be read: ") + std::strerror(errno)};
    Header header{};
    if (bytes->size() < sizeof header) return {{}, "is truncated"};
    std::memcpy(&header, bytes->data(), sizeof header);
    const std::string_view payload = std::string_view(*bytes).substr(sizeof header);
    if (header.magic != magic) return {{}, "is no cache file"};
    if (header.version != format_version)
        return {{}, "has format version " + std::to_string(header.version) + ", not " + std::to_string(format_version)};
    if (header.key != key) return {{}, "belongs to something else"};
    if (header.payload_bytes != payload.size()) return {{}, "is truncated"};
    if (header.checksum != Hash().add_bytes(payload.data(), payload.size()).value()) return {{}, "is damaged"};
    Found found{unpack(payload, tets), {}};
    if (!found.materials) found.problem = "does not fit its tree";
    return found;
}

/// Returns what went wrong, empty for nothing.
std::string save(const std::filesystem::path& path, std::uint64_t key, const CoarseMaterials& materials) {
    static std::atomic<unsigned> counter = 0;
    std::error_code error;
    std::filesystem::create_directories(path.parent_path(), error);
    if (error) return "cannot be made: " + error.message();
    std::filesystem::path temporary = path;
    std::ostringstream suffix;
    suffix << '.' << ::getpid() << '.' << counter++ << ".tmp";
    temporary += suffix.str();

    const std::string payload = pack(materials);
    const Header header{magic, format_version, key, payload.size(),
                        Hash().add_bytes(payload.data(), payload.size()).value()};
    std::string problem;
    {
        const File file(temporary, O_WRONLY | O_CREAT | O_EXCL);
        const bool written = file.open() && file.write({reinterpret_cast<const char*>(&header), sizeof header}) &&
                             file.write(payload) && file.sync();
        if (!written) problem = std::string("cannot be written: ") + std::strerror(errno);
    }
    if (problem.empty() && ::rename(temporary.c_str(), path.c_str()) != 0)
        problem = std::string("cannot be renamed: ") + std::strerror(errno);
    if (!problem.empty()) {
        std::filesystem::remove(temporary, error);
        return problem;
    }
    // The new name reaches the disk with its directory. Where directories cannot be flushed the file is still complete.
    if (const File directory(path.parent_path(), O_RDONLY | O_DIRECTORY); directory.open())
        static_cast<void>(directory.sync());
    return {};
}

std::filesystem::path file_of(std::uint64_t key, const std::filesystem::path& directory) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "%016llx.elasticity", static_cast<unsigned long long>(key));
    return directory / name.data();
}

}  // namespace

std::filesystem::path default_cache_directory() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && cache[0] == '/')
        return std::filesystem::path(cache) / "tetfront";
    if (const char* home = std::getenv("HOME"); home && *home)
        return std::filesystem::path(home) / ".cache" / "tetfront";
    return {};
}

std::filesystem::path cache_file(const TetTree& tree, const StiffnessFunction& function,
                                 const EstimationSettings& settings, const std::filesystem::path& directory) {
    return file_of(key_of(tree, function, settings), directory);
}

CoarseMaterials coarse_materials(const TetTree& tree, const StiffnessFunction& function,
                                 const EstimationSettings& settings, const CacheSettings& cache,
                                 const Progress& progress) {
    const auto report = [&](const char* stage, double fraction) {
        if (progress) progress(stage, fraction);
    };
    const auto warn = [&](const std::string& line) {
        if (cache.warn) cache.warn(line);
    };
    const std::uint64_t key = cache.directory.empty() ? 0 : key_of(tree, function, settings);
    const std::filesystem::path path =
        cache.directory.empty() ? std::filesystem::path() : file_of(key, cache.directory);
    if (!path.empty()) {
        Found found = load(path, key, tree.tet_count());
        if (found.materials) {
            report("reading elasticity matrices", 1);
            return std::move(*found.materials);
        }
        if (!found.problem.empty()) warn("cache file " + path.string() + " " + found.problem + "; computing it again");
    }
    const LeafMaterials leaves =
        integrate_leaves(tree, function, [&](double f) { report("integrating the material", f); });
    CoarseMaterials materials;
    materials.matrices = estimate_elasticity(
        tree, leaves, settings, [&](double f) { report("estimating elasticity matrices", f); });
    materials.density = coarse_density(tree, leaves);
    if (!path.empty()) {
        const std::string problem = save(path, key, materials);
        if (!problem.empty()) warn("cache file " + path.string() + " " + problem + "; going on without a cache");
    }
    return materials;
}

}  // namespace tetfront
