// SPDX-License-Identifier: Apache-2.0
// Parts of a beauty: light by where it comes from and by how often it was scattered on its way, as
// light path expressions name them. Made from the finished tree of a sample, so that nothing is
// traced or kept for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "irt/scene/scene.h"
#include "irt/shade/shading.h"

namespace irt::shade {

/// How often light was scattered between its source and the eye. What passes a surface that is not
/// wholly there is not scattered by it. Any: all of it. None: sources that are seen themselves.
/// Once: direct light, and sources seen in a mirror or through glass. More: all further light.
enum class Events : std::uint8_t { Any, None, Once, More, Some };

/// A part of the beauty that is asked for.
struct BeautyPart {
    std::string name;
    Events events = Events::Any;
    bool emission = true;  ///< of surfaces
    /// Lights by their paths, those below included, or by their bare names. Absent: all.
    std::optional<std::vector<std::string>> lights;
};

/// The same under the lights of a scene.
struct ResolvedPart {
    Events events;
    std::vector<bool> columns;  ///< the unscaled term, then by light: those it sums
};
std::vector<ResolvedPart> resolved(const std::vector<BeautyPart>& parts, const Scene& scene);

/// A column of a sample's tree, by events. `Tree` has, of nodes of its type Handle:
///     bool meets(Handle), passes(Handle)   sees a surface; its second branch goes by it
///     V3f own(Handle, column), cumulative(Handle, column)
///     std::optional<Handle> branch(Handle, which), V3f weight(Handle)
template <class Tree>
class ByEvents {
  public:
    using Node = typename Tree::Handle;
    ByEvents(const Tree& tree, std::size_t column) : tree_(tree), column_(column) {}

    [[nodiscard]] V3f sum(Events events, Node node) const {
        switch (events) {
            case Events::Any:
                return tree_.cumulative(node, column_);
            case Events::None:
                return none(node);
            case Events::Once:
                return once(node);
            case Events::Some:
                return some(node);
            case Events::More:
                return more(node);
        }
        return {0, 0, 0};
    }

  private:
    /// `sum` and what joins it from the branches: scattered(branch), or, of what passes a surface,
    /// passed(branch).
    template <class Scattered, class Passed>
    [[nodiscard]] V3f joined(V3f sum, Node node, Scattered&& scattered, Passed&& passed) const {
        for (int which = 0; which < 2; ++which) {
            const std::optional<Node> branch = tree_.branch(node, which);
            if (!branch) continue;
            const bool passes = which == 1 && tree_.passes(node);
            sum = add_scaled(sum, tree_.weight(*branch),
                             passes ? passed(*branch) : scattered(*branch));
        }
        return sum;
    }
    [[nodiscard]] V3f lit(Node node) const {
        return column_ == 0 ? V3f(0, 0, 0) : tree_.own(node, column_);
    }
    [[nodiscard]] V3f none(Node node) const {
        if (!tree_.meets(node)) return tree_.cumulative(node, column_);
        return joined(
            column_ == 0 ? tree_.own(node, 0) : V3f(0, 0, 0), node,
            [](Node) { return V3f(0, 0, 0); }, [this](Node past) { return none(past); });
    }
    [[nodiscard]] V3f once(Node node) const {
        if (!tree_.meets(node)) return {0, 0, 0};
        return joined(
            lit(node), node, [this](Node below) { return none(below); },
            [this](Node past) { return once(past); });
    }
    [[nodiscard]] V3f some(Node node) const {
        if (!tree_.meets(node)) return {0, 0, 0};
        return joined(
            lit(node), node, [this](Node below) { return sum(Events::Any, below); },
            [this](Node past) { return some(past); });
    }
    [[nodiscard]] V3f more(Node node) const {
        if (!tree_.meets(node)) return {0, 0, 0};
        return joined(
            V3f(0, 0, 0), node, [this](Node below) { return some(below); },
            [this](Node past) { return more(past); });
    }

    const Tree& tree_;
    std::size_t column_;
};

/// A part of the beauty of the sample whose tree begins at `root`.
template <class Tree>
V3f part_of(const ResolvedPart& part, const Tree& tree, typename Tree::Handle root,
            const std::vector<LightSlot>& lights) {
    V3d sum(0, 0, 0);
    for (std::size_t c = 0; c < part.columns.size(); ++c) {
        if (!part.columns[c]) continue;
        const V3d column(ByEvents<Tree>(tree, c).sum(part.events, root));
        sum += c == 0 ? column : V3d(lights[c - 1].record.energy) * column;
    }
    return V3f(sum);
}

/// The tree of one sample that is traced without a history.
class SampleTree {
  public:
    using Handle = std::size_t;
    void clear(std::size_t columns) {
        columns_ = columns;
        nodes_.clear();
        values_.clear();
    }
    /// A node that meets nothing.
    Handle add() {
        nodes_.push_back({});
        values_.resize(values_.size() + 2 * columns_, V3f(0, 0, 0));
        return nodes_.size() - 1;
    }
    void meet(Handle node, bool passes) {
        nodes_[node].meets = true;
        nodes_[node].passes = passes;
    }
    void join(Handle node, int which, Handle branch, const V3f& weight) {
        nodes_[node].branches[which] = branch;
        nodes_[branch].weight = weight;
    }
    enum Value : std::size_t { Own, Cumulative };
    void set(Handle node, Value value, std::size_t column, const V3f& intensity) {
        values_[2 * (node * columns_ + column) + value] = intensity;
    }
    /// Where the tree will have its next node.
    [[nodiscard]] Handle end() const { return nodes_.size(); }

    [[nodiscard]] bool meets(Handle node) const { return nodes_[node].meets; }
    [[nodiscard]] bool passes(Handle node) const { return nodes_[node].passes; }
    [[nodiscard]] const V3f& own(Handle node, std::size_t column) const {
        return values_[2 * (node * columns_ + column) + Own];
    }
    [[nodiscard]] const V3f& cumulative(Handle node, std::size_t column) const {
        return values_[2 * (node * columns_ + column) + Cumulative];
    }
    [[nodiscard]] std::optional<Handle> branch(Handle node, int which) const {
        const Handle found = nodes_[node].branches[which];
        if (found == no_branch) return std::nullopt;
        return found;
    }
    [[nodiscard]] const V3f& weight(Handle node) const { return nodes_[node].weight; }

  private:
    static constexpr Handle no_branch = ~Handle{0};
    struct Kept {
        bool meets = false, passes = false;
        Handle branches[2] = {no_branch, no_branch};
        V3f weight{0, 0, 0};
    };
    std::size_t columns_ = 0;
    std::vector<Kept> nodes_;
    std::vector<V3f> values_;  ///< own, cumulative; by node and column
};

}  // namespace irt::shade
