/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "palette/palette_clusters.h"
#include "palette/palette_fit.h"

/* The default: greedy k-means++, Lloyd, then two searches that go on where Lloyd stops.
 *
 *   exchange  one item moves to another cluster when the two resultants together become longer (Hartigan): with
 *             few items an entry this is well below Lloyd's optimum, since an item pulls its own entry towards it.
 *   swap      the entry that is missed least is taken away and set where it gains most, the neighbourhood is
 *             exchanged, and all is undone unless the total improved. */

typedef struct saved_cluster {
    uint32_t k;
    double sum[3], norm;
    float axis[3];
} saved_cluster;

typedef struct search {
    clusters *c;
    uint8_t *queued;           /* clusters that the next pass looks at */
    uint32_t *list, *next_list;
    size_t list_count, next_count;
    double *split_gain, *removal_loss; /* a cluster */
    /* The journal of a trial. */
    bool recording;
    uint8_t *touched;
    saved_cluster *saved;
    size_t saved_count;
    uint32_t *moved_item, *moved_from;
    size_t moved_count, moved_capacity;
    bool full; /* the journal ran out: the trial is undone */
} search;

static double norm3(const double s[3]) { return sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]); }

/* |S + r u| without a square of S. */
static double joined_norm(const cluster *k, const float *u, double r)
{
    double s[3] = {k->sum[0] + r * (double)u[0], k->sum[1] + r * (double)u[1], k->sum[2] + r * (double)u[2]};
    return norm3(s);
}

static void queue(search *s, uint32_t k)
{
    if (s->queued[k])
        return;
    s->queued[k] = 1;
    s->next_list[s->next_count++] = k;
}

static void save_cluster(search *s, uint32_t k)
{
    if (!s->recording || s->touched[k])
        return;
    s->touched[k] = 1;
    saved_cluster *save = &s->saved[s->saved_count++];
    *save = (saved_cluster){.k = k, .norm = s->c->cluster[k].norm};
    for (int a = 0; a < 3; ++a) {
        save->sum[a] = s->c->cluster[k].sum[a];
        save->axis[a] = s->c->axis[a][k];
    }
}

static void unlink_item(clusters *c, uint32_t item)
{
    uint32_t before = c->previous[item], after = c->next[item];
    if (before == NO_ITEM)
        c->cluster[c->owner[item]].head = after;
    else
        c->next[before] = after;
    if (after != NO_ITEM)
        c->previous[after] = before;
}

static void link_item(clusters *c, uint32_t item, uint32_t k)
{
    cluster *own = &c->cluster[k];
    c->owner[item] = k;
    c->previous[item] = NO_ITEM;
    c->next[item] = own->head;
    if (own->head != NO_ITEM)
        c->previous[own->head] = item;
    own->head = item;
}

static void add_to_sum(clusters *c, uint32_t k, uint32_t item, double sign)
{
    cluster *own = &c->cluster[k];
    for (size_t a = 0; a < 3; ++a)
        own->sum[a] += sign * c->r[item] * (double)c->u[3 * item + a];
    own->norm = norm3(own->sum);
    for (int a = 0; a < 3 && own->norm > 0; ++a)
        c->axis[a][k] = (float)(own->sum[a] / own->norm);
}

static void move_item(search *s, uint32_t item, uint32_t to)
{
    clusters *c = s->c;
    uint32_t from = c->owner[item];
    if (s->recording) {
        if (s->moved_count == s->moved_capacity) {
            s->full = true;
            return;
        }
        s->moved_item[s->moved_count] = item;
        s->moved_from[s->moved_count++] = from;
    }
    save_cluster(s, from);
    save_cluster(s, to);
    unlink_item(c, item);
    link_item(c, item, to);
    add_to_sum(c, from, item, -1);
    add_to_sum(c, to, item, 1);
    queue(s, from);
    queue(s, to);
}

/* Where the item makes the two resultants longest; its own cluster when nowhere. */
static uint32_t best_exchange(const clusters *c, uint32_t item)
{
    uint32_t from = c->owner[item], best = from;
    const cluster *own = &c->cluster[from];
    const float *u = c->u + 3 * item;
    double r = c->r[item];
    double loss = own->norm - joined_norm(own, u, -r);
    double most = loss * (1 + 1e-9) + 1e-12 * own->norm; /* moves on rounding alone would go on for ever */
    float threshold = (float)(most / r);
    for (uint32_t j = 0; j < own->neighbor_count; ++j) {
        uint32_t k = own->neighbor[j];
        float dot = clusters_dot(c, k, u);
        double along = c->cluster[k].norm + r * (double)dot;
        /* |S + ru| - |S| is at most r dot + r^2 (1 - dot^2) / (2 (|S| + r dot)). */
        if (along > 0 && dot + (float)(0.5 * r * (1.000001 - (double)(dot * dot)) / along) + 1e-6f < threshold)
            continue;
        double gain = joined_norm(&c->cluster[k], u, r) - c->cluster[k].norm;
        if (gain > most)
            most = gain, best = k;
    }
    return best;
}

/* Exchanges inside the queued clusters, and those that change by it, until nothing moves. */
static void exchange(search *s, size_t passes)
{
    clusters *c = s->c;
    for (size_t pass = 0; pass < passes && s->next_count && !s->full; ++pass) {
        uint32_t *list = s->list;
        s->list = s->next_list;
        s->list_count = s->next_count;
        s->next_list = list;
        s->next_count = 0;
        for (size_t i = 0; i < s->list_count; ++i)
            s->queued[s->list[i]] = 0;
        for (size_t i = 0; i < s->list_count && !s->full; ++i)
            for (uint32_t item = c->cluster[s->list[i]].head, after; item != NO_ITEM && !s->full; item = after) {
                after = c->next[item];
                uint32_t to = best_exchange(c, item);
                if (to != c->owner[item])
                    move_item(s, item, to);
            }
    }
    for (size_t i = 0; i < s->next_count; ++i)
        s->queued[s->next_list[i]] = 0;
    s->next_count = 0;
}

/* ---- swaps ------------------------------------------------------------------------------ */

/* Two means inside one cluster, from its most distant item and the one most distant from that. Returns how much
 * longer the two resultants are than the one; `side` is the second entry. */
static double split_cluster(const clusters *c, uint32_t k, float side[3])
{
    const cluster *own = &c->cluster[k];
    float a[3] = {c->axis[0][k], c->axis[1][k], c->axis[2][k]}, b[3];
    if (own->head == NO_ITEM || c->next[own->head] == NO_ITEM)
        return -1;
    for (int end = 0; end < 2; ++end) {
        float least = 2;
        uint32_t farthest = own->head;
        for (uint32_t i = own->head; i != NO_ITEM; i = c->next[i]) {
            const float *u = c->u + 3 * i;
            float dot = u[0] * a[0] + u[1] * a[1] + u[2] * a[2];
            if (dot < least)
                least = dot, farthest = i;
        }
        memcpy(end ? b : a, c->u + 3 * farthest, sizeof a);
    }
    double gain = 0;
    for (int round = 0; round < 4; ++round) {
        double second[3] = {0, 0, 0}, first[3];
        for (uint32_t i = own->head; i != NO_ITEM; i = c->next[i]) {
            const float *u = c->u + 3 * i;
            float lead = u[0] * (b[0] - a[0]) + u[1] * (b[1] - a[1]) + u[2] * (b[2] - a[2]);
            double r = lead > 0 ? c->r[i] : 0;
            for (int d = 0; d < 3; ++d)
                second[d] += r * (double)u[d];
        }
        for (int d = 0; d < 3; ++d)
            first[d] = own->sum[d] - second[d];
        double first_norm = norm3(first), second_norm = norm3(second);
        if (!(first_norm > 0) || !(second_norm > 0))
            break;
        gain = first_norm + second_norm - own->norm;
        for (int d = 0; d < 3; ++d) {
            a[d] = (float)(first[d] / first_norm);
            b[d] = (float)(second[d] / second_norm);
        }
    }
    memcpy(side, b, sizeof b);
    return gain;
}

/* The entry other than its own that suits the item best. */
static uint32_t second_best(const clusters *c, uint32_t item, float *best_dot)
{
    const cluster *own = &c->cluster[c->owner[item]];
    uint32_t best = c->owner[item];
    *best_dot = -2;
    for (uint32_t j = 0; j < own->neighbor_count; ++j) {
        float dot = clusters_dot(c, own->neighbor[j], c->u + 3 * item);
        if (dot > *best_dot)
            *best_dot = dot, best = own->neighbor[j];
    }
    return best;
}

/* What is lost when the entry goes and its items take the next best. */
static double removal_loss(const clusters *c, uint32_t k)
{
    double kept = 0;
    for (uint32_t i = c->cluster[k].head; i != NO_ITEM; i = c->next[i]) {
        float dot;
        second_best(c, i, &dot);
        kept += c->r[i] * (double)dot;
    }
    return c->cluster[k].norm - kept;
}

static void rate(search *s, uint32_t k)
{
    float side[3];
    s->split_gain[k] = split_cluster(s->c, k, side);
    s->removal_loss[k] = removal_loss(s->c, k);
}

/* Takes entry k away from where it is and splits `target` with it. */
static void relocate(search *s, uint32_t k, uint32_t target, const float side[3])
{
    clusters *c = s->c;
    save_cluster(s, k);
    while (c->cluster[k].head != NO_ITEM && !s->full) {
        float dot;
        uint32_t item = c->cluster[k].head;
        move_item(s, item, second_best(c, item, &dot));
    }
    float middle[3] = {c->axis[0][target], c->axis[1][target], c->axis[2][target]};
    iso_clusters_set_entry(c, k, side);
    memset(c->cluster[k].sum, 0, sizeof c->cluster[k].sum);
    c->cluster[k].norm = 0;
    /* Those that are clearly on its side of the middle; the exchange does the rest. */
    float across[3], even = 0;
    for (int d = 0; d < 3; ++d) {
        across[d] = side[d] - middle[d];
        even += middle[d] * across[d];
    }
    for (uint32_t i = c->cluster[target].head, after; i != NO_ITEM && !s->full; i = after) {
        const float *u = c->u + 3 * i;
        after = c->next[i];
        if (u[0] * across[0] + u[1] * across[1] + u[2] * across[2] > even * 0.5f)
            move_item(s, i, k);
    }
    iso_clusters_find_neighbors(c, k);
    /* Those around it do not know it yet; it takes the place of their farthest neighbour. */
    cluster *own = &c->cluster[k];
    for (uint32_t j = 0; j < own->neighbor_count; ++j) {
        cluster *other = &c->cluster[own->neighbor[j]];
        bool known = false;
        for (uint32_t i = 0; i < other->neighbor_count; ++i)
            known |= other->neighbor[i] == k;
        if (!known && other->neighbor_count)
            other->neighbor[other->neighbor_count - 1] = k;
        queue(s, own->neighbor[j]);
    }
}

static void undo(search *s)
{
    clusters *c = s->c;
    for (size_t i = s->moved_count; i-- > 0;) {
        unlink_item(c, s->moved_item[i]);
        link_item(c, s->moved_item[i], s->moved_from[i]);
    }
    for (size_t i = 0; i < s->saved_count; ++i) {
        const saved_cluster *save = &s->saved[i];
        memcpy(c->cluster[save->k].sum, save->sum, sizeof save->sum);
        c->cluster[save->k].norm = save->norm;
        iso_clusters_set_entry(c, save->k, save->axis);
    }
}

/* One swap. True when the total grew; else all is as before. */
static bool try_swap(search *s, uint32_t k, uint32_t target)
{
    clusters *c = s->c;
    float side[3];
    if (k == target || split_cluster(c, target, side) < 0)
        return false;
    const cluster before = c->cluster[k];
    s->recording = true;
    s->saved_count = s->moved_count = 0;
    s->full = false;
    relocate(s, k, target, side);
    exchange(s, 4);
    double change = 0, size = 0;
    for (size_t i = 0; i < s->saved_count; ++i) {
        change += c->cluster[s->saved[i].k].norm - s->saved[i].norm;
        size += s->saved[i].norm;
    }
    bool better = !s->full && change > 1e-10 * size;
    if (!better) {
        undo(s);
        c->cluster[k].neighbor_count = before.neighbor_count;
        memcpy(c->cluster[k].neighbor, before.neighbor, sizeof before.neighbor);
        memcpy(c->cluster[k].neighbor_dot, before.neighbor_dot, sizeof before.neighbor_dot);
    }
    for (size_t i = 0; i < s->saved_count; ++i) {
        s->touched[s->saved[i].k] = 0;
        if (better)
            rate(s, s->saved[i].k);
    }
    s->recording = false;
    s->full = false;
    return better;
}

/* Of a few clusters drawn the one of the least value. */
static uint32_t tournament(iso_random *random, const double *value, double sign, size_t count, int draws)
{
    uint32_t best = (uint32_t)iso_random_below(random, count);
    for (int i = 1; i < draws; ++i) {
        uint32_t k = (uint32_t)iso_random_below(random, count);
        if (sign * value[k] < sign * value[best])
            best = k;
    }
    return best;
}

static uint32_t extreme(const double *value, double sign, size_t count)
{
    uint32_t best = 0;
    for (uint32_t k = 1; k < count; ++k)
        if (sign * value[k] < sign * value[best])
            best = k;
    return best;
}

static void refresh(search *s)
{
    clusters *c = s->c;
    for (uint32_t k = 0; k < c->count; ++k)
        iso_clusters_find_neighbors(c, k);
    for (uint32_t k = 0; k < c->count; ++k)
        rate(s, k);
}

static void search_swaps(search *s, size_t trials, iso_random *random, const iso_progress *progress)
{
    size_t count = s->c->count, since_refresh = 0;
    refresh(s);
    /* First those that gain by their own figures; each improves the total, so they end. */
    for (size_t i = 0; i < count; ++i) {
        uint32_t k = extreme(s->removal_loss, 1, count), target = extreme(s->split_gain, -1, count);
        if (!(s->split_gain[target] > s->removal_loss[k]) || !try_swap(s, k, target))
            break;
    }
    for (size_t i = 0; i < trials; ++i) {
        if (++since_refresh > count) {
            refresh(s);
            since_refresh = 0;
            iso_progress_report(progress, "palette", (double)i / (double)trials);
        }
        uint32_t k = tournament(random, s->removal_loss, 1, count, 4);
        uint32_t target = tournament(random, s->split_gain, -1, count, 4);
        try_swap(s, k, target);
    }
}

static void search_destroy(search *s)
{
    free(s->queued);
    free(s->list);
    free(s->next_list);
    free(s->split_gain);
    free(s->removal_loss);
    free(s->touched);
    free(s->saved);
    free(s->moved_item);
    free(s->moved_from);
}

static iso_status improve(clusters *c, size_t trials, iso_random *random, const iso_progress *progress, iso_error *err)
{
    size_t n = c->count, capacity = 4 * c->item_count + 64;
    search s = {.c = c, .moved_capacity = capacity};
    s.queued = calloc(n, 1);
    s.touched = calloc(n, 1);
    s.list = malloc(n * sizeof *s.list);
    s.next_list = malloc(n * sizeof *s.next_list);
    s.split_gain = malloc(n * sizeof *s.split_gain);
    s.removal_loss = malloc(n * sizeof *s.removal_loss);
    s.saved = malloc(n * sizeof *s.saved);
    s.moved_item = malloc(capacity * sizeof *s.moved_item);
    s.moved_from = malloc(capacity * sizeof *s.moved_from);
    iso_status status = ISO_OK;
    if (!s.queued || !s.touched || !s.list || !s.next_list || !s.split_gain || !s.removal_loss || !s.saved ||
        !s.moved_item || !s.moved_from) {
        status = iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu clusters of %zu bundles", n, c->item_count);
    } else {
        for (uint32_t k = 0; k < n; ++k)
            iso_clusters_find_neighbors(c, k);
        for (uint32_t k = 0; k < n; ++k)
            queue(&s, k);
        exchange(&s, 30);
        search_swaps(&s, trials * n, random, progress);
        for (uint32_t k = 0; k < n; ++k)
            iso_clusters_find_neighbors(c, k);
        for (uint32_t k = 0; k < n; ++k)
            queue(&s, k);
        exchange(&s, 30);
    }
    search_destroy(&s);
    return status;
}

/* ---- seeds by splitting (Linde, Buzo, Gray 1980) -------------------------------------------- */

/* Doubles the code book, or splits the costliest entries where doubling is too much, and runs Lloyd after each. */
static iso_status grow_by_splitting(clusters *c, const iso_direction_set *set, iso_error *err)
{
    size_t wanted = c->count;
    iso_clusters_set_entry(c, 0, set->xyz);
    memset(c->owner, 0, c->item_count * sizeof *c->owner);
    c->count = 1;
    iso_clusters_collect(c);
    while (c->count < wanted) {
        size_t now = c->count, room = wanted - now;
        double *gain = malloc(now * sizeof *gain);
        if (!gain)
            return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu clusters", wanted);
        float side[3];
        for (uint32_t k = 0; k < now; ++k)
            gain[k] = split_cluster(c, k, side);
        for (size_t i = 0; i < now && i < room; ++i) {
            uint32_t k = extreme(gain, -1, now), fresh = (uint32_t)c->count;
            if (split_cluster(c, k, side) < 0)
                break;
            gain[k] = -2;
            ++c->count;
            iso_clusters_set_entry(c, fresh, side);
            c->cluster[fresh] = (cluster){.head = NO_ITEM};
        }
        free(gain);
        /* Every cluster of one item: cannot be, as there are more items than entries. */
        if (c->count == now)
            break;
        iso_clusters_assign_all(c);
        iso_clusters_lloyd(c, 20);
    }
    return ISO_OK;
}

/* ---- the fit ------------------------------------------------------------------------------- */

/* No more directions than entries: each is an entry of its own. */
static iso_status one_entry_each(const iso_direction_set *set, iso_palette *palette, iso_error *err)
{
    iso_status status = iso_palette_create(palette, set->count, err);
    if (status == ISO_OK && set->count)
        memcpy(palette->xyz + 3, set->xyz, 3 * set->count * sizeof *palette->xyz);
    return status;
}

/* Swaps are tried on a set of at most this many bundles an entry: enough to tell where entries are missed. */
#define SEARCH_BUNDLES 32

/* The coarse set that is fine enough: the more concentrated the directions, the finer its cells. */
static iso_status coarsen(const iso_direction_set *set, size_t entries, iso_direction_set *out, iso_error *err)
{
    static const int cells[] = {96, 64, 48, 32, 24, 16};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < sizeof cells / sizeof *cells; ++i) {
        iso_direction_set_destroy(out);
        status = iso_direction_set_coarsen(set, cells[i], out, err);
        if (status != ISO_OK || out->count <= SEARCH_BUNDLES * entries)
            break;
    }
    return status;
}

static iso_status fit_search(clusters *c, const iso_palette_options *opt, iso_random *random,
                             const iso_progress *progress, iso_error *err)
{
    iso_status status = iso_clusters_seed_greedy(c, random, err);
    if (status != ISO_OK)
        return status;
    iso_clusters_lloyd(c, 20);
    status = improve(c, opt->swap_trials, random, progress, err);
    /* The exchange looks at neighbours only; this makes each item's owner the nearest of all. */
    iso_clusters_lloyd(c, 2);
    return status;
}

/* Large sets: the search on a coarse one, then Lloyd on all. */
static iso_status fit_large(clusters *c, const iso_direction_set *set, const iso_palette_options *opt,
                            iso_random *random, const iso_progress *progress, iso_error *err)
{
    iso_direction_set coarse = {0};
    clusters few = {0};
    iso_status status = coarsen(set, c->count, &coarse, err);
    if (status == ISO_OK && coarse.count <= c->count) {
        /* All lie in a few cells: nothing is gained by bundling them. */
        iso_direction_set_destroy(&coarse);
        return fit_search(c, opt, random, progress, err);
    }
    if (status == ISO_OK)
        status = iso_clusters_create(&few, &coarse, c->count, err);
    if (status == ISO_OK)
        status = fit_search(&few, opt, random, progress, err);
    for (uint32_t k = 0; status == ISO_OK && k < c->count; ++k)
        for (int a = 0; a < 3; ++a)
            c->axis[a][k] = few.axis[a][k];
    iso_clusters_destroy(&few);
    iso_direction_set_destroy(&coarse);
    if (status == ISO_OK) {
        iso_clusters_assign_all(c);
        iso_clusters_lloyd(c, 10);
    }
    return status;
}

static iso_status fit_clusters(clusters *c, const iso_direction_set *set, const iso_palette_options *opt,
                               const iso_progress *progress, iso_error *err)
{
    iso_random random = {opt->seed};
    iso_status status = ISO_OK;
    switch (opt->method) {
    case ISO_PALETTE_KMEANS:
        return set->count > SEARCH_BUNDLES * c->count ? fit_large(c, set, opt, &random, progress, err)
                                                      : fit_search(c, opt, &random, progress, err);
    case ISO_PALETTE_LLOYD: iso_clusters_seed_random(c, &random); break;
    case ISO_PALETTE_LBG: status = grow_by_splitting(c, set, err); break;
    default: status = iso_clusters_seed_greedy(c, &random, err);
    }
    if (status == ISO_OK)
        iso_clusters_lloyd(c, 200);
    return status;
}

iso_status iso_palette_fit_kmeans(const iso_direction_set *set, const iso_palette_options *opt, iso_palette *palette,
                                  const iso_progress *progress, iso_error *err)
{
    if (set->count <= opt->directions)
        return one_entry_each(set, palette, err);
    clusters c;
    iso_status status = iso_clusters_create(&c, set, opt->directions, err);
    if (status == ISO_OK)
        status = fit_clusters(&c, set, opt, progress, err);
    if (status == ISO_OK)
        status = iso_palette_create(palette, opt->directions, err);
    for (size_t k = 0; status == ISO_OK && k < opt->directions; ++k)
        for (size_t a = 0; a < 3; ++a)
            palette->xyz[3 * (k + 1) + a] = c.axis[a][k];
    iso_clusters_destroy(&c);
    return status;
}
