static REAL @min(REAL a, REAL b)
{
    return b < a ? b : a;
}

static REAL @max(REAL a, REAL b)
{
    return b > a ? b : a;
}

/* x held within low and high */
static REAL @limit(REAL x, REAL low, REAL high)
{
    const REAL above = low > x ? low : x;
    return high < above ? high : above;
}

static REAL @power_2(REAL x)
{
    return x * x;
}

static REAL @power_3(REAL x)
{
    return x * x * x;
}

static REAL @power_4(REAL x)
{
    return (x * x) * (x * x);
}

/* the largest k with nodes[k] <= x, from 0 to count - 2 */
static int @interval(REAL x, const REAL *nodes, int count)
{
    int low = 0;
    int high = count - 1;
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        if (nodes[middle] <= x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* of the line between the two nodes around x */
static REAL @slope(REAL x, const REAL *nodes, const REAL *values, int count)
{
    const int k = @interval(x, nodes, count);
    return (values[k + 1] - values[k]) / (nodes[k + 1] - nodes[k]);
}

/* linear between the nodes; x is held within the first and the last */
static REAL @line(REAL x, const REAL *nodes, const REAL *values, int count)
{
    const int k = @interval(x, nodes, count);
    const REAL slope = (values[k + 1] - values[k]) / (nodes[k + 1] - nodes[k]);
    return values[k] + slope * (@limit(x, nodes[0], nodes[count - 1]) - nodes[k]);
}

/* the value of the node below x */
static REAL @hold(REAL x, const REAL *nodes, const REAL *values, int count)
{
    return values[@interval(x, nodes, count)];
}

/* the weight of each rule: for each premise w where the rule has 1, and 1 - w where it has 0 */
static void @weigh(REAL *weights, const unsigned char *rules, int count, const REAL *w,
                   int premises)
{
    int i;
    int k;
    for (i = 0; i < count; i++) {
        REAL product = ONE;
        for (k = 0; k < premises; k++) {
            product = product * (rules[i * premises + k] != 0 ? w[k] : ONE - w[k]);
        }
        weights[i] = product;
    }
}

/* the sum of the values times their weights */
static REAL @mix(const REAL *weights, const REAL *values, int count)
{
    REAL sum = ZERO;
    int i;
    for (i = 0; i < count; i++) {
        sum = sum + weights[i] * values[i];
    }
    return sum;
}

/* the largest j with knots[j] <= x, from 3 to count - 5 */
static int @knot(REAL x, const REAL *knots, int count)
{
    int low = 3;
    int high = count - 4;
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        if (knots[middle] <= x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* cubic B-splines at x between knots[k] and knots[k + 1]; d holds their four coefficients */
static REAL @de_boor(REAL x, const REAL *knots, int k, REAL *d)
{
    int r;
    int j;
    for (r = 1; r <= 3; r++) {
        for (j = 3; j >= r; j--) {
            const REAL below = knots[j + k - 3];
            const REAL share = (x - below) / (knots[j + 1 + k - r] - below);
            d[j] = (ONE - share) * d[j - 1] + share * d[j];
        }
    }
    return d[3];
}

/* a cubic spline; x is held within the knots */
static REAL @spline(REAL x, const REAL *knots, int count, const REAL *coefficients)
{
    const REAL held = @limit(x, knots[3], knots[count - 4]);
    const int k = @knot(held, knots, count);
    REAL d[4];
    int j;
    for (j = 0; j < 4; j++) {
        d[j] = coefficients[k - 3 + j];
    }
    return @de_boor(held, knots, k, d);
}

/* a cubic spline of x and y; one row of coefficients for each spline of x */
static REAL @spline_2(REAL x, REAL y, const REAL *knots_x, int count_x, const REAL *knots_y,
                      int count_y, const REAL *coefficients)
{
    const REAL held = @limit(x, knots_x[3], knots_x[count_x - 4]);
    const int k = @knot(held, knots_x, count_x);
    REAL d[4];
    int j;
    for (j = 0; j < 4; j++) {
        d[j] = @spline(y, knots_y, count_y, coefficients + (k - 3 + j) * (count_y - 4));
    }
    return @de_boor(held, knots_x, k, d);
}
