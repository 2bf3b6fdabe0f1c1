// SPDX-License-Identifier: Apache-2.0
// What a checkpoint holds, as named arrays: gathered without copies, and put back.
//
// A type that is kept has one function `archive(Archive&, name, self)`, which names everything of
// it that outlives an update; it begins by decomposing `self` with a structured binding, so that a
// member more does not compile until it is thought of. `Archive` is ArrayWriter or ArrayReader.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <memory_resource>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace irt::checkpoint {

/// Arrays of at least a page begin on one, so that they can be mapped; smaller ones on a line.
inline constexpr std::size_t page = 4096, line = 64;

/// What its bytes are all of. (Imath's vectors are, though they have copy constructors.)
template <class T>
inline constexpr bool is_plain =
    std::is_trivially_destructible_v<T>&& std::is_standard_layout_v<T> && !std::is_pointer_v<T>;

/// An array on its way to a file: pieces of memory that follow each other there.
struct ArrayEntry {
    std::string name;
    std::string type;       ///< numpy's: <u4, |V64
    std::size_t item_size;  ///< bytes
    std::size_t count;
    std::size_t offset;  ///< from the start of the data
    std::vector<std::span<const std::byte>> pieces;
};

template <class T>
std::string type_name() {
    const char kind = std::is_floating_point_v<T> ? 'f'
                      : !std::is_integral_v<T>    ? 'V'
                      : std::is_signed_v<T>       ? 'i'
                                                  : 'u';
    return (kind == 'V' || sizeof(T) == 1 ? '|' : '<') + (kind + std::to_string(sizeof(T)));
}

/// Gathers arrays where they are; they must stand until they are written.
class ArrayWriter {
  public:
    static constexpr bool reads = false;

    /// A single value.
    template <class T>
    void value(const std::string& name, const T& value) {
        static_assert(is_plain<T>);
        const auto* bytes = reinterpret_cast<const std::byte*>(&value);
        const std::vector<std::byte>& kept = values_.emplace_back(bytes, bytes + sizeof(T));
        add(name, type_name<T>(), sizeof(T), 1, {std::span<const std::byte>(kept)});
    }
    template <class Array>
    void array(const std::string& name, const Array& array) {
        using Item = typename Array::value_type;
        static_assert(is_plain<Item>);
        add(name, type_name<Item>(), sizeof(Item), array.size(),
            {std::as_bytes(std::span(array.data(), array.size()))});
    }
    /// `count` arrays of one type, array(i) each, as one that follow each other.
    template <class At>
    void arrays(const std::string& name, std::size_t count, At&& at) {
        using Item = typename std::remove_cvref_t<decltype(at(0))>::value_type;
        static_assert(is_plain<Item>);
        std::vector<std::span<const std::byte>> pieces;
        std::vector<std::uint64_t> sizes;
        std::size_t items = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const auto& array = at(i);
            sizes.push_back(array.size());
            items += array.size();
            pieces.push_back(std::as_bytes(std::span(array.data(), array.size())));
        }
        add(name, type_name<Item>(), sizeof(Item), items, std::move(pieces));
        copied(name + ".sizes", sizes);
    }
    /// A small array that does not stand until then.
    template <class T>
    void copied(const std::string& name, const std::vector<T>& array) {
        const std::span<const std::byte> bytes = std::as_bytes(std::span(array));
        const std::vector<std::byte>& kept = values_.emplace_back(bytes.begin(), bytes.end());
        add(name, type_name<T>(), sizeof(T), array.size(), {std::span<const std::byte>(kept)});
    }
    /// Has `value`, whose arrays are to be added, stand until then.
    template <class T>
    const T& keep(T value) {
        auto kept = std::make_shared<const T>(std::move(value));
        kept_.push_back(kept);
        return *kept;
    }
    /// Any memory, such as a host's own array.
    void add(const std::string& name, const std::string& type, std::size_t item_size,
             std::size_t count, std::vector<std::span<const std::byte>> pieces) {
        const std::size_t bytes = item_size * count, aligned = bytes < page ? line : page;
        const std::size_t offset = (end_ + aligned - 1) / aligned * aligned;
        end_ = offset + bytes;
        entries_.push_back({name, type, item_size, count, offset, std::move(pieces)});
    }

    [[nodiscard]] const std::vector<ArrayEntry>& entries() const { return entries_; }
    /// Bytes of all arrays with what lies between them.
    [[nodiscard]] std::size_t size() const { return end_; }

  private:
    std::vector<ArrayEntry> entries_;
    std::deque<std::vector<std::byte>> values_;
    std::vector<std::shared_ptr<const void>> kept_;
    std::size_t end_ = 0;
};

/// Where a file's arrays lie in memory. Throws std::runtime_error, naming the array, where one is
/// missing or is not what is asked for.
class ArrayReader {
  public:
    static constexpr bool reads = true;
    struct Stored {
        std::span<const std::byte> bytes;
        std::size_t item_size;
    };

    explicit ArrayReader(std::map<std::string, Stored> arrays) : arrays_(std::move(arrays)) {}

    template <class T>
    void value(const std::string& name, T& value) {
        static_assert(is_plain<T>);
        const std::span<const std::byte> bytes = find(name, sizeof(T));
        if (bytes.size() != sizeof(T)) throw std::runtime_error(name + ": holds no single value");
        std::memcpy(static_cast<void*>(&value), bytes.data(), sizeof(T));
    }
    template <class Array>
    void array(const std::string& name, Array& array) {
        copy(find(name, sizeof(typename Array::value_type)), array);
    }
    template <class At>
    void arrays(const std::string& name, std::size_t count, At&& at) {
        using Array = std::remove_reference_t<decltype(at(0))>;
        std::vector<std::uint64_t> sizes;
        array(name + ".sizes", sizes);
        if (sizes.size() != count) throw std::runtime_error(name + ": holds another number");
        std::span<const std::byte> bytes = find(name, sizeof(typename Array::value_type));
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t size = sizes[i] * sizeof(typename Array::value_type);
            if (size > bytes.size()) throw std::runtime_error(name + ": ends too early");
            copy(bytes.first(size), at(i));
            bytes = bytes.subspan(size);
        }
    }

    /// Of what `arrays` will read.
    [[nodiscard]] std::size_t count(const std::string& name) const {
        return find(name + ".sizes", sizeof(std::uint64_t)).size() / sizeof(std::uint64_t);
    }
    /// Of all arrays whose names begin so.
    [[nodiscard]] std::size_t bytes(const std::string& prefix) const {
        std::size_t sum = 0;
        for (auto at = arrays_.lower_bound(prefix);
             at != arrays_.end() && at->first.starts_with(prefix); ++at)
            sum += at->second.bytes.size();
        return sum;
    }

  private:
    [[nodiscard]] std::span<const std::byte> find(const std::string& name,
                                                  std::size_t item_size) const {
        const auto found = arrays_.find(name);
        if (found == arrays_.end()) throw std::runtime_error(name + ": is not there");
        if (found->second.item_size != item_size)
            throw std::runtime_error(name + ": its items are of another size");
        return found->second.bytes;
    }
    template <class Array>
    static void copy(std::span<const std::byte> bytes, Array& array) {
        using Item = typename Array::value_type;
        static_assert(is_plain<Item>);
        array.resize(bytes.size() / sizeof(Item));
        if (!bytes.empty())
            std::memcpy(static_cast<void*>(array.data()), bytes.data(), bytes.size());
    }

    std::map<std::string, Stored> arrays_;
};

}  // namespace irt::checkpoint
