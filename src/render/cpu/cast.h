/* SPDX-License-Identifier: MIT */
/* cast.h - input of the CPU ray caster's packets of rays (cast_packet.h), made once per picture by caster.c.
 *
 * Scalar, codes and the other channels lie in bricks of 16^3 cells. A brick has the voxels of its cells' far faces,
 * too, so the eight voxels of a cell are at fixed offsets from the first. A cell is the cube between eight voxel centers;
 * the grid has one more voxel at each end, a copy of the outermost, so that clamping at the edge needs no test:
 *
 *     voxel    -1     0     1            N-1    N
 *               o-----o-----o--- ... ---o-----o
 *     cell         0     1     2              N        cell c begins at voxel c - 1
 *     box             [========= ... =====]            0 to N in index coordinates
 *
 * Positions are counted in cells: index + 1/2.
 *
 * Bricks of mixed resolution (mixed.h) have their own nodes. Positions are counted in cells of level 0, index - 1/2 +
 * ISO_CAST_OUTER: so blocks of 4 cells do not lie across bricks, and what is outside the first nodes is above 0.
 * Private to src/render/cpu. */
#pragma once

#include "base/linalg.h"
#include "scene/scene.h"

enum {
    ISO_CAST_BRICK_SHIFT = 4, /* bricks of 16 cells a side */
    ISO_CAST_BRICK = 1 << ISO_CAST_BRICK_SHIFT,
    ISO_CAST_ROW = ISO_CAST_BRICK + 1, /* voxels from a brick's row to its next */
    ISO_CAST_PLANE = ISO_CAST_ROW * ISO_CAST_ROW,
    ISO_CAST_VOXELS = ISO_CAST_PLANE * ISO_CAST_ROW, /* of a brick */
    ISO_CAST_BLOCK_SHIFT = 2,                        /* empty space is known by blocks of 4 cells a side */
    ISO_CAST_TILE = 32,                              /* pixels along the edge of a tile, the work unit of a thread */
    ISO_CAST_OUTER = 4,      /* cells in front of the first node of bricks of mixed resolution */
    ISO_CAST_LEVEL_BITS = 3, /* of the number that says where such a brick is */
};

/* How the shading normal is made. */
typedef enum iso_cast_normals {
    ISO_CAST_UNLIT,     /* no light can be seen: there is none */
    ISO_CAST_LATTICE,   /* filtered bytes of codes, decoded */
    ISO_CAST_VECTORS,   /* filtered floats */
    ISO_CAST_FLIPPED,   /* floats that are turned to one side, then filtered */
    ISO_CAST_NEAREST,   /* the floats of the voxel that holds the point */
    ISO_CAST_ON_THE_FLY, /* central differences of the filtered scalar */
    ISO_CAST_NODES       /* the filtered directions of bricks of mixed resolution */
} iso_cast_normals;

typedef struct iso_cast_light {
    double direction[3];
    float diffuse, specular; /* intensity times the material's */
} iso_cast_light;

/* The table's entry i and how far it is to the next: value, step, value, step ... of optical depth (of a whole
 * segment), red, green and blue. */
enum { ISO_CAST_DEPTH = 0, ISO_CAST_GREEN = 4, ISO_CAST_ENTRY = 8 };

struct iso_cast_maker;
typedef struct iso_cast {
    /* the camera, in doubles */
    size_t width, height;
    bool orthographic;
    double half_width, half_height, forward[3], right[3], up[3];
    double to_index[9]; /* rows first */
    double position[3]; /* of the camera, index coordinates */
    double cells_before; /* cells in front of index 0 */
    double box[3], step_mm;
    size_t clip_count;
    double clips[ISO_MAX_CLIP_PLANES][4]; /* index coordinates */
    /* the volume, in bricks; NULL if it is not read */
    int32_t size[3], brick_stride[3]; /* from a brick to the next, in voxels; in bricks if there are slots */
    /* If bricks are pages (paged.h) or are made one by one: the first voxel of each; below 0: it is missing. Else
     * NULL. */
    const int32_t *slots;
    /* If bricks are made when a ray needs them (caster.c), otherwise NULL: makes a missing brick and returns its
     * slot. Any thread may call it. */
    int32_t (*make_brick)(struct iso_cast_maker *maker, int32_t brick);
    struct iso_cast_maker *maker;
    bool has_integers; /* True if scalars have at most 16 bits: they are kept less the least value. Otherwise they are
                        * kept as floats, scaled to their range */
    const uint16_t *integers; /* scalars alone: these ... */
    const float *floats;      /* ... or these */
    const uint32_t *voxels;   /* or voxel_words per voxel, which one fetch takes: three bytes of code, and the scalar in
                               * the fourth, or in a second word, as an integer or as a float's bits */
    int32_t voxel_words;
    bool labels;              /* not filtered */
    /* Bricks of mixed resolution, otherwise NULL: the first node of each times 8, plus its level; -1: it is left out.
     * Its nodes are scalars alone as above, integers in 65535 steps of the range; or they have directions, too: */
    const int32_t *places;
    int32_t places_shift[2];     /* the next brick along y is 2^places_shift[0] numbers on, along z 2^places_shift[1] */
    int32_t cells_shift;         /* a brick has 2^cells_shift cells of level 0 a side */
    int32_t last_cell[3];        /* of the volume, counted from the first node */
    const uint32_t *small_nodes; /* four numbers of 16 bits in two words, direction and scalar ... */
    const float *large_nodes;    /* ... or four floats */
    const float *vectors[3];  /* directions */
    const uint16_t *second, *scale; /* bytes of a 2D transfer function and of the extinction's scale */
    /* the transfer function: a value's entry is value * entries_per_value + first_entry */
    const float *entries;
    int32_t entry_count, row_count; /* row_count: of a 2D one, otherwise 0 */
    float entries_per_value, first_entry;
    /* light */
    iso_cast_normals normals;
    bool is_signed;
    int decoder;
    float gradient_to_world[9], on_the_fly_eps; /* of differences of the values above */
    size_t light_count;
    iso_cast_light lights[ISO_MAX_LIGHTS];
    bool specular;
    float ambient, power, background[3];
    /* Empty space: NULL if it is not used. If bricks are pages: each block's distance to the nearest one that the
     * transfer function shows. */
    const uint8_t *distance;
    int32_t block_count[3];
    /* Of all others: such distances for each octant of directions (brick/occupancy.h); of each block two words whose
     * bits are cells that can show something, x fastest, the first word of the cells with the lesser z. */
    const uint8_t *octants;
    const int32_t *cells;
    int32_t blocks;
    float margin; /* cells; how far a place may be off that is known in floats alone */
    /* with them: where along their rays the pixels of a tile can show anything (render/screen_reach.h) */
    const float *reach_mm;
    size_t reach_columns;
} iso_cast;

/* Where the rays of a tile stand between two passes over pages (paged.h), in the order of the tile's packets. */
enum { ISO_CAST_RAYS = ISO_CAST_TILE * ISO_CAST_TILE, ISO_CAST_NEW = -1, ISO_CAST_DONE = -2 };
typedef struct iso_cast_rays {
    int32_t wants[ISO_CAST_RAYS]; /* the brick that the ray waits for, or one of the two above */
    int32_t k[ISO_CAST_RAYS];     /* its next segment */
    float sum[4][ISO_CAST_RAYS], rest[4][ISO_CAST_RAYS];
} iso_cast_rays;

/* Requests of rays, two bytes per brick: a ray waits for it; it lies ahead of one that waits. */
enum { ISO_CAST_WANTED, ISO_CAST_AHEAD, ISO_CAST_ASKED };

/* Takes each ray of a tile as far as its bricks are there. Returns how many rays wait. */
typedef size_t iso_cast_paged_tile(const iso_cast *c, size_t x, size_t y, iso_cast_rays *rays, uint8_t *asked,
                                   float *rgba);
iso_cast_paged_tile iso_cast_paged_tile_1, iso_cast_paged_tile_4, iso_cast_paged_tile_8, iso_cast_paged_tile_16;

/* Draws pixels [x, x + ISO_CAST_TILE) of rows [y, y + ISO_CAST_TILE), as far as the image goes. One function per width;
 * all give the same bits. */
typedef void iso_cast_tile(const iso_cast *c, size_t x, size_t y, float *rgba);
iso_cast_tile iso_cast_tile_1, iso_cast_tile_4, iso_cast_tile_8, iso_cast_tile_16;

/* A field whose pictures have derivatives (adjoint.h), its tile, and the gradient. */
typedef struct iso_cast_field {
    int32_t size[3], stride[3];
    const float *voxels, *octaves;
} iso_cast_field;
typedef struct iso_cast_tile_at {
    size_t x, y;
    uint32_t seed;
    float *rgba;           /* ISO_CAST_RAYS pixels */
    const float *by_pixel; /* derivatives of the sum by them */
} iso_cast_tile_at;
typedef struct iso_cast_gradient {
    float *voxels, *octaves, *table; /* table: extinction first */
} iso_cast_gradient;

/* Draws the tile, pixels outside the picture, too; or, if there is a gradient, adds to it. */
typedef void iso_cast_adjoint(const iso_cast *c, const iso_cast_field *f, const iso_cast_tile_at *t,
                              const iso_cast_gradient *g);
iso_cast_adjoint iso_cast_adjoint_1, iso_cast_adjoint_4, iso_cast_adjoint_8, iso_cast_adjoint_16;
