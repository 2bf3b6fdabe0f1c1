// SPDX-License-Identifier: Apache-2.0
// Embree proposes, the judges decide: the callbacks, and one query through them. How the trees come
// to be is in trees.cpp.
#include "irt/trace/intersector.h"

#include <cstddef>

#include "irt/trace/candidate.h"
#include "irt/trace/judge_primitive.h"
#include "irt/trace/trees.h"

namespace irt::trace {
namespace {

/// One query of one tree; handed through Embree to the callbacks, which find it by its first
/// member.
struct Query {
    embree::Context context;
    const Scene* scene;
    const JudgeRay* ray;  ///< in the tree's trace space
    EmbreeRay embree_ray;
    std::uint32_t instance;  ///< object slot whose prototype this tree is within, or `none`
    std::uint32_t part;      ///< what to add to part numbers of this tree
    std::uint8_t rays;       ///< a RayKind
    QueryCounts* counts;
    union {
        Hit* best;
        Occlusion* sum;
    };
    const Ray* shadow_ray = nullptr;   ///< in render space, of a query with a sum
    const ShadowRule* rule = nullptr;  ///< likewise: the light's, or null
    Hit* behind = nullptr;  ///< where not null: the nearest hit on another object than best's

    /// Everything up to this has to be found.
    [[nodiscard]] double reach() const { return behind ? behind->t : best->t; }
};

Query& query_of(void* context) { return *reinterpret_cast<Query*>(context); }

void load(const Query& query, float t_far, RTCRay& ray) {
    static_assert(offsetof(RTCRay, tnear) == offsetof(RTCRay, org_x) + 12 &&
                  offsetof(RTCRay, time) == offsetof(RTCRay, dir_x) + 12);
    _mm_store_ps(&ray.org_x, query.embree_ray.origin);
    _mm_store_ps(&ray.dir_x, query.embree_ray.direction);
    ray.tfar = t_far;
    ray.mask = ~0u;
    ray.id = 0;
    ray.flags = 0;
}

void search(RTCScene tree, Query& query) {
    RTCRayHit ray;
    load(query, query.embree_ray.limit(query.reach()), ray.ray);
    ray.hit.geomID = ray.hit.primID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    embree::intersect(tree, query.context, ray);
}

/// Takes `hit` for the query if it is nearer than what it has; true if the search may end sooner.
bool take(const Hit& hit, Query& query) {
    const Scene& scene = *query.scene;
    Hit &best = *query.best, *behind = query.behind;
    if (!behind || hit.object == best.object) return take_if_nearer(scene, hit, best) && !behind;
    const Hit was = best;
    if (!take_if_nearer(scene, hit, best)) return take_if_nearer(scene, hit, *behind);
    *behind = was;
    return true;
}

/// True once nothing passes.
bool search_any(RTCScene tree, Query& query, double t_max) {
    RTCRay ray;
    load(query, query.embree_ray.limit(t_max), ray);
    embree::occluded(tree, query.context, ray);
    return ray.tfar < 0;
}

/// Calls found(hit) for each triangle of a primitive that the ray meets within its limits, until
/// that returns true.
template <class Found>
void judge_leaf(const Shape& shape, std::size_t leaf, Query& query, Found&& found) {
    const TrianglePacket& packet = shape.packets[leaf];
    const auto* bytes = reinterpret_cast<const char*>(&packet);
    for (std::size_t line = 64; line < sizeof packet; line += 64)  // mostly far from the caches
        _mm_prefetch(bytes + line, _MM_HINT_T0);
    query.counts->candidates += 2 * packet_pairs;
    PacketHits met;
    if (!judge_packet(packet, *query.ray, met)) return;
    for (unsigned bits = met.inside | met.alone; bits != 0; bits &= bits - 1) {
        const int bit = __builtin_ctz(bits), side = bit / 4, lane = bit % 4;
        TriangleHit triangle;
        if (!finish_lane(packet, *query.ray, met, side, lane, triangle)) continue;
        if (!(triangle.t > 0 && triangle.t < query.ray->t_max)) continue;
        if (shape.single_sided && !triangle.front) continue;
        Hit hit;
        hit.t = triangle.t;
        hit.u = triangle.u;
        hit.v = triangle.v;
        hit.object = query.instance == none ? shape.object : query.instance;
        hit.part = query.part + shape.part;
        hit.primitive = packet.triangle(side, lane);
        if (found(hit)) return;
    }
}

void intersect_packet(const RTCIntersectFunctionNArguments* arguments) {
    const auto& shape = *static_cast<const Shape*>(arguments->geometryUserPtr);
    Query& query = query_of(arguments->context);
    if (!(shape.rays & query.rays)) return;
    judge_leaf(shape, arguments->primID, query, [&](const Hit& hit) {
        if (take(hit, query))
            reinterpret_cast<RTCRayHit*>(arguments->rayhit)->ray.tfar =
                query.embree_ray.limit(query.reach());
        return false;
    });
}

void occlude_packet(const RTCOccludedFunctionNArguments* arguments) {
    const auto& shape = *static_cast<const Shape*>(arguments->geometryUserPtr);
    Query& query = query_of(arguments->context);
    if (!(shape.rays & query.rays)) return;
    judge_leaf(shape, arguments->primID, query, [&](const Hit& hit) {
        if (!add_occluder(*query.scene, *query.shadow_ray, hit, *query.sum, query.rule))
            return false;
        reinterpret_cast<RTCRay*>(arguments->ray)->tfar = -std::numeric_limits<float>::infinity();
        return true;
    });
}

/// Judges a quadric, ball or segment.
bool judge_shape(const Shape& shape, std::uint32_t primitive, Query& query, Hit& hit) {
    query.counts->candidates += 1;
    if (!judge_solid(shape.surface, primitive, *query.ray, hit)) return false;
    hit.object = query.instance == none ? shape.object : query.instance;
    hit.part = query.part + shape.part;
    return true;
}

void intersect_solid(const RTCIntersectFunctionNArguments* arguments) {
    const auto& shape = *static_cast<const Shape*>(arguments->geometryUserPtr);
    Query& query = query_of(arguments->context);
    if (!(shape.rays & query.rays)) return;
    Hit hit;
    if (judge_shape(shape, arguments->primID, query, hit) && take(hit, query))
        reinterpret_cast<RTCRayHit*>(arguments->rayhit)->ray.tfar =
            query.embree_ray.limit(query.reach());
}

void occlude_solid(const RTCOccludedFunctionNArguments* arguments) {
    const auto& shape = *static_cast<const Shape*>(arguments->geometryUserPtr);
    Query& query = query_of(arguments->context);
    if (!(shape.rays & query.rays)) return;
    Hit hit;
    if (judge_shape(shape, arguments->primID, query, hit) &&
        add_occluder(*query.scene, *query.shadow_ray, hit, *query.sum, query.rule))
        reinterpret_cast<RTCRay*>(arguments->ray)->tfar = -std::numeric_limits<float>::infinity();
}

/// An instance on a ray's way.
struct Entered {
    const Group* group;
    M44d prototype_from_trace;
    std::uint32_t slot, part;  ///< of the object; what its hits' part numbers begin with
};

/// The same ray in the prototype's space, ready to search its tree. False if it misses the box.
bool enter_instance(const Entered& instance, const Query& outer, double t_limit, JudgeRay& local,
                    Query& inner) {
    transform_ray(instance.prototype_from_trace, *outer.ray, local);
    if (!anchor(instance.group->frame, local, t_limit, inner.embree_ray)) return false;
    embree::init(inner.context);
    inner.scene = outer.scene;
    inner.ray = &local;
    inner.instance = instance.slot;
    inner.part = instance.part;
    inner.rays = outer.rays;
    inner.counts = outer.counts;
    return true;
}

void intersect_group(const Entered& instance, Query& outer, float& t_far) {
    JudgeRay local;
    Query inner;
    if (!enter_instance(instance, outer, outer.reach(), local, inner)) return;
    inner.best = outer.best;
    inner.behind = outer.behind;
    search(instance.group->tree.get(), inner);
    t_far = outer.embree_ray.limit(outer.reach());
}

void occlude_group(const Entered& instance, Query& outer, float& t_far) {
    JudgeRay local;
    Query inner;
    if (!enter_instance(instance, outer, outer.ray->t_max, local, inner)) return;
    inner.sum = outer.sum;
    inner.shadow_ray = outer.shadow_ray;
    inner.rule = outer.rule;
    if (search_any(instance.group->tree.get(), inner, outer.ray->t_max))
        t_far = -std::numeric_limits<float>::infinity();
}

/// What one of Embree's primitives that is an instance leads to. False: nothing is there.
bool find_instance(const Shape& shape, const Query& query, std::uint32_t, Entered& entered) {
    entered.group = shape.group.get();
    entered.prototype_from_trace = shape.prototype_from_trace;
    entered.slot = shape.object;
    entered.part = 0;
    return (shape.rays & query.rays) != 0;
}

bool find_entry(const Shape& shape, const Query& query, std::uint32_t primitive, Entered& entered) {
    const std::uint32_t slot = shape.slots[primitive];
    if (!(shape.rays & query.rays) || (shape.moved && (*shape.moved)[slot])) return false;
    entered.group = &shape.group_of_slot(slot);
    entered.prototype_from_trace = query.scene->prototype_from_render(slot);
    entered.slot = slot;
    entered.part = 0;
    return true;
}

bool find_nested(const Shape& shape, const Query& query, std::uint32_t primitive,
                 Entered& entered) {
    const NestedArray& array = *shape.nested;
    entered.group = shape.nested_groups[array.record->prototype(primitive)].get();
    entered.prototype_from_trace = inverse_of(array.outer_from_prototype(primitive));
    entered.slot = query.instance;
    entered.part = query.part + array.first_part + primitive * array.stride;
    return (shape.rays & query.rays) && entered.group->tree != nullptr;
}

template <auto find>
void intersect_instance(const RTCIntersectFunctionNArguments* arguments) {
    const auto& shape = *static_cast<const Shape*>(arguments->geometryUserPtr);
    Query& outer = query_of(arguments->context);
    Entered entered;
    if (find(shape, outer, arguments->primID, entered))
        intersect_group(entered, outer, reinterpret_cast<RTCRayHit*>(arguments->rayhit)->ray.tfar);
}

template <auto find>
void occlude_instance(const RTCOccludedFunctionNArguments* arguments) {
    const auto& shape = *static_cast<const Shape*>(arguments->geometryUserPtr);
    Query& outer = query_of(arguments->context);
    Entered entered;
    if (find(shape, outer, arguments->primID, entered))
        occlude_group(entered, outer, reinterpret_cast<RTCRay*>(arguments->ray)->tfar);
}

/// Range of largest direction components that need no scaling: far from where Embree drops signs.
constexpr float least_direction = 0x1p-6f, greatest_direction = 0x1p30f;

/// The float ray for the two outer trees. False if the ray cannot meet anything.
bool aim(const Frame& frame, const Ray& ray, const JudgeRay& judged, EmbreeRay& out) {
    const float reach =
        std::max({std::fabs(ray.origin.x), std::fabs(ray.origin.y), std::fabs(ray.origin.z)});
    const float direction = std::fabs(ray.direction[judged.kz]);
    if (!(static_cast<double>(reach) <= frame.half && direction >= least_direction &&
          direction <= greatest_direction))
        return anchor(frame, judged, judged.t_max, out);
    out.origin = _mm_set_ps(0, ray.origin.z, ray.origin.y, ray.origin.x);
    out.direction = _mm_set_ps(0, ray.direction.z, ray.direction.y, ray.direction.x);
    out.start = 0;
    out.scale = 1;
    return true;
}

}  // namespace

const Callbacks& callbacks() {
    static constexpr Callbacks all{
        {intersect_packet, occlude_packet},
        {intersect_solid, occlude_solid},
        {intersect_instance<find_instance>, occlude_instance<find_instance>},
        {intersect_instance<find_entry>, occlude_instance<find_entry>},
        {intersect_instance<find_nested>, occlude_instance<find_nested>}};
    return all;
}

struct Intersector::Impl {
    Trees trees;
};

Intersector::Intersector(const std::string& isa, int threads, TreeOptions options)
    : impl_(new Impl{Trees(isa, threads, options)}) {}

Intersector::~Intersector() = default;

void Intersector::follow(const AppliedChanges& applied) { impl_->trees.follow(applied); }

void Intersector::commit(const Scene& scene, const std::vector<std::uint32_t>& changed) {
    impl_->trees.commit(scene, changed);
}

TreesState Intersector::state() const { return impl_->trees.state(); }

void Intersector::commit(const Scene& scene, const std::vector<std::uint32_t>& changed,
                         const TreesState& state) {
    impl_->trees.commit(scene, changed, state);
}

void Intersector::search_nearest(const Ray& ray, unsigned which, Hit& best, Hit* behind,
                                 QueryCounts& counts) const {
    const Trees& trees = impl_->trees;
    ++counts.nearest;
    const JudgeRay judged = judge_ray(ray);
    Query query;
    if (!trees.scene() || !aim(trees.frame(), ray, judged, query.embree_ray)) return;
    if (!best) best.t = judged.t_max;
    embree::init(query.context);
    query.scene = trees.scene();
    query.ray = &judged;
    query.instance = none;
    query.part = 0;
    query.rays = ray.camera ? camera_ray : other_ray;
    query.counts = &counts;
    query.best = &best;
    query.behind = behind;
    if ((which & still_tree) && trees.still()) search(trees.still(), query);
    // What moves is never kept behind: it hides the still hits, it does not replace them.
    if ((which & moving_tree) && trees.moving()) {
        const Hit still = best;
        query.behind = nullptr;
        search(trees.moving(), query);
        if (behind && still && best.object != still.object) *behind = still;
    }
    if (!best) best.t = std::numeric_limits<double>::infinity();
}

Hit Intersector::nearest(const Ray& ray, QueryCounts& counts) const {
    Hit best;
    search_nearest(ray, still_tree | moving_tree, best, nullptr, counts);
    return best;
}

Hit Intersector::nearest_and_behind(const Ray& ray, Hit& behind, QueryCounts& counts) const {
    Hit best;
    behind = Hit();
    search_nearest(ray, still_tree | moving_tree, best, &behind, counts);
    return best;
}

Hit Intersector::nearest_moving(const Ray& ray, const Hit& limit, QueryCounts& counts) const {
    Hit best = limit;
    search_nearest(ray, moving_tree, best, nullptr, counts);
    return best;
}

bool Intersector::moves(std::uint32_t slot) const { return impl_->trees.moves(slot); }

std::uint32_t Intersector::epoch() const { return impl_->trees.epoch(); }

Box Intersector::box(std::uint32_t slot) const { return impl_->trees.box(slot); }

Box Intersector::box(const CompiledPrototype& prototype, const M44d& render_from_prototype) const {
    return impl_->trees.box(prototype, render_from_prototype);
}

double Intersector::pad() const { return impl_->trees.frame().pad(); }

Occlusion Intersector::occlusion_in(const Ray& ray, unsigned which, QueryCounts& counts,
                                    const ShadowRule* rule) const {
    const Trees& trees = impl_->trees;
    ++counts.occlusion;
    const JudgeRay judged = judge_ray(ray);
    Occlusion sum;
    Query query;
    if (!trees.scene() || !aim(trees.frame(), ray, judged, query.embree_ray)) return sum;
    embree::init(query.context);
    query.scene = trees.scene();
    query.ray = &judged;
    query.instance = none;
    query.part = 0;
    query.rays = ray.camera ? camera_ray : other_ray;
    query.counts = &counts;
    query.sum = &sum;
    query.shadow_ray = &ray;
    query.rule = rule;
    if ((which & still_tree) && trees.still() && search_any(trees.still(), query, judged.t_max))
        return sum;
    if ((which & moving_tree) && trees.moving()) search_any(trees.moving(), query, judged.t_max);
    return sum;
}

Occlusion Intersector::occlusion(const Ray& ray, QueryCounts& counts,
                                 const ShadowRule* rule) const {
    return occlusion_in(ray, still_tree | moving_tree, counts, rule);
}

Occlusion Intersector::occlusion_moving(const Ray& ray, QueryCounts& counts,
                                        const ShadowRule* rule) const {
    return occlusion_in(ray, moving_tree, counts, rule);
}

}  // namespace irt::trace
