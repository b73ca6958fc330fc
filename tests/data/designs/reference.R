# What R says about data.csv beside it: writes r_output.csv and r_session.txt.
# Run once, in this folder: Rscript reference.R
# Debian: r-base-core r-cran-{afex,coin,effectsize,lmertest}. What has no package here is written in base R, by
# the formula that is named beside it.
suppressPackageStartupMessages({
  library(afex)
  library(coin)
  library(effectsize)
  library(lmerTest)
})
options(warn = 1)

found <- list()
add <- function(analysis, dataset, ...) {
  values <- c(...)
  stopifnot(!is.null(names(values)), all(nzchar(names(values))))
  text <- ifelse(is.finite(values), sprintf("%.17g", values), "")
  found[[length(found) + 1]] <<- data.frame(
    analysis = analysis, dataset = dataset, quantity = names(values), value = text
  )
}
data <- read.csv("data.csv")
of <- function(dataset, group) data$value[data$dataset == dataset & data$group == group]
SIDES <- c("two-sided" = "two.sided", greater = "greater", less = "less")

# --- Mann-Whitney: coin is exact with ties; wilcox.test gives the interval without ties ---------
for (name in c("distinct", "tied", "uneven", "separate", "large")) {
  a <- of(name, "a"); b <- of(name, "b")
  long <- data.frame(y = c(a, b), g = factor(rep(c("a", "b"), c(length(a), length(b)))))
  u <- sum(outer(a, b, ">")) + sum(outer(a, b, "==")) / 2
  for (side in names(SIDES)) {
    normal <- wilcox_test(y ~ g, long, distribution = "asymptotic", alternative = SIDES[[side]])
    values <- c(as.numeric(pvalue(normal)))
    names(values) <- paste("p_asymptotic", side)
    if (name != "large") {
      exact <- wilcox_test(y ~ g, long, distribution = "exact", alternative = SIDES[[side]])
      values[paste("p_exact", side)] <- as.numeric(pvalue(exact))
    }
    add("mann_whitney", name, values)
  }
  z <- as.numeric(statistic(normal, type = "standardized"))
  add("mann_whitney", name, u = u, z = z, shift = median(outer(a, b, "-")),
      rank_biserial = rank_biserial(a, b, ci = NULL)$r_rank_biserial)
  # Newcombe (2006), method 5: the roots of (p - theta)^2 = z^2 V(theta).
  n <- length(a); m <- length(b); p <- u / (n * m); q <- qnorm(.975); half <- (n + m) / 2 - 1
  gap <- function(t) (p - t)^2 -
    q^2 * t * (1 - t) * (1 + half * ((1 - t) / (2 - t) + t / (1 + t))) / (n * m)
  low <- if (p == 0) 0 else uniroot(gap, c(0, min(p, 1 - 1e-9)), tol = 1e-14)$root
  high <- if (p == 1) 1 else uniroot(gap, c(max(p, 1e-9), 1), tol = 1e-14)$root
  add("mann_whitney", name, effect_low = 2 * low - 1, effect_high = 2 * high - 1)
}
exact <- wilcox.test(of("distinct", "a"), of("distinct", "b"), exact = TRUE, conf.int = TRUE)
add("mann_whitney", "distinct", shift_low = exact$conf.int[1], shift_high = exact$conf.int[2])

# --- t tests, Hedges' g, equivalence ------------------------------------------------------------
add_t <- function(analysis, name, test) {
  difference <- if (length(test$estimate) == 2) -diff(test$estimate) else test$estimate
  add(analysis, name, t = unname(test$statistic), df = unname(test$parameter), p = test$p.value,
      low = test$conf.int[1], high = test$conf.int[2], mean = unname(difference),
      standard_error = test$stderr)
}
for (name in c("distinct", "tied", "uneven", "separate", "large")) {
  a <- of(name, "a"); b <- of(name, "b")
  add_t("welch", name, t.test(a, b))
  add_t("pooled", name, t.test(a, b, var.equal = TRUE))
  g <- hedges_g(a, b)
  add("welch", name, g = g$Hedges_g, g_low = g$CI_low, g_high = g$CI_high)
  add("welch", name, p_greater = t.test(a, b, alternative = "greater")$p.value,
      low_greater = t.test(a, b, alternative = "greater")$conf.int[1])
  low <- t.test(a, b, mu = -3, alternative = "greater")
  high <- t.test(a, b, mu = 3, alternative = "less")
  add("tost_groups", name, t_low = unname(low$statistic), t_high = unname(high$statistic),
      p_low = low$p.value, p_high = high$p.value,
      low = t.test(a, b, conf.level = .9)$conf.int[1],
      high = t.test(a, b, conf.level = .9)$conf.int[2])
}
for (name in c("pairs", "few_pairs")) {
  a <- of(name, "a"); b <- of(name, "b")
  add_t("paired", name, t.test(a, b, paired = TRUE))
  g <- hedges_g(a, b, paired = TRUE)
  add("paired", name, g = g$Hedges_g, g_low = g$CI_low, g_high = g$CI_high)
  low <- t.test(a, b, mu = -2, alternative = "greater", paired = TRUE)
  high <- t.test(a, b, mu = 2, alternative = "less", paired = TRUE)
  add("tost_pairs", name, t_low = unname(low$statistic), t_high = unname(high$statistic),
      p_low = low$p.value, p_high = high$p.value,
      low = t.test(a, b, paired = TRUE, conf.level = .9)$conf.int[1],
      high = t.test(a, b, paired = TRUE, conf.level = .9)$conf.int[2])
  # JZS Bayes factor by the integral of Rouder et al. (2009, equation 1), prior scale sqrt(2)/2.
  jzs <- function(t, n, df, r = sqrt(2) / 2) {
    inner <- function(g) (1 + n * g * r^2)^-.5 * (1 + t^2 / ((1 + n * g * r^2) * df))^(-(df + 1) / 2) *
      (2 * pi)^-.5 * g^-1.5 * exp(-1 / (2 * g))
    integrate(inner, 0, Inf, rel.tol = 1e-10)$value / (1 + t^2 / df)^(-(df + 1) / 2)
  }
  test <- t.test(a, b, paired = TRUE)
  add("paired", name, bf = jzs(unname(test$statistic), length(a), length(a) - 1))
  # Sign test
  d <- (a - b)[a != b]
  for (side in names(SIDES)) {
    sign <- binom.test(sum(d > 0), length(d), alternative = SIDES[[side]])
    values <- c(sign$p.value, sign$conf.int)
    names(values) <- paste(c("p", "share_low", "share_high"), side)
    add("sign", name, values)
  }
}
for (name in c("distinct", "tied", "uneven")) {
  a <- of(name, "a"); b <- of(name, "b"); n <- length(a); m <- length(b)
  t <- unname(t.test(a, b, var.equal = TRUE)$statistic)
  add("pooled", name, bf = jzs(t, n * m / (n + m), n + m - 2))
}

# --- Kruskal-Wallis -----------------------------------------------------------------------------
three <- data[data$dataset == "three", ]
test <- kruskal.test(value ~ factor(group), three)
add("kruskal_wallis", "three", h = unname(test$statistic), p = test$p.value,
    epsilon_squared = rank_epsilon_squared(value ~ group, data = three, ci = NULL)$rank_epsilon_squared)

# --- Correlations -------------------------------------------------------------------------------
for (name in c("pairs", "few_pairs")) {
  a <- of(name, "a"); b <- of(name, "b"); n <- length(a)
  pearson <- cor.test(a, b)
  add("pearson", name, estimate = unname(pearson$estimate), p = pearson$p.value,
      low = pearson$conf.int[1], high = pearson$conf.int[2])
  kendall <- suppressWarnings(cor.test(a, b, method = "kendall", exact = FALSE))
  tau <- unname(kendall$estimate)
  add("kendall", name, estimate = tau, p = kendall$p.value,
      low = tanh(atanh(tau) - qnorm(.975) * sqrt(.437 / (n - 4))),
      high = tanh(atanh(tau) + qnorm(.975) * sqrt(.437 / (n - 4))))
  rho <- cor(rank(a), rank(b)); error <- sqrt((1 + rho^2 / 2) / (n - 3)) # Bonett & Wright (2000)
  add("spearman", name, estimate = rho, low = tanh(atanh(rho) - qnorm(.975) * error),
      high = tanh(atanh(rho) + qnorm(.975) * error))
  add("spearman", name, p = if (n > 8) cor.test(rank(a), rank(b))$p.value else {
    long <- data.frame(a, b) # every order of b
    permute <- function(v) if (length(v) < 2) list(v) else
      do.call(c, lapply(seq_along(v), function(i) lapply(permute(v[-i]), function(r) c(v[i], r))))
    all <- sapply(permute(seq_along(b)), function(o) cor(rank(a), rank(b)[o]))
    mean(abs(all) >= abs(rho) - 1e-9)
  })
}
distinct <- of("distinct", "a"); other <- of("distinct", "b")[seq_along(distinct)]
kendall <- cor.test(distinct, other, method = "kendall")
add("kendall", "distinct", estimate = unname(kendall$estimate), p = kendall$p.value)
# Repeated-measures correlation: the analysis of covariance of Bland & Altman (1995).
repeated <- data[data$dataset == "repeated", ]
x <- repeated$value[repeated$group %in% c("x1", "x2")]
y <- repeated$value[repeated$group %in% c("x3", "x4")]
who <- factor(repeated$participant[repeated$group %in% c("x1", "x2")])
table <- anova(lm(y ~ who + x))
slope <- coef(lm(y ~ who + x))[["x"]]
df <- table["Residuals", "Df"]
r <- sign(slope) * sqrt(table["x", "Sum Sq"] / (table["x", "Sum Sq"] + table["Residuals", "Sum Sq"]))
add("repeated_measures", "repeated", estimate = r, df = df, p = table["x", "Pr(>F)"],
    low = tanh(atanh(r) - qnorm(.975) / sqrt(df - 1)),
    high = tanh(atanh(r) + qnorm(.975) / sqrt(df - 1)))

# --- Preferences: Wilson's interval is that of prop.test without correction ---------------------
for (counts in list(c(14, 5, 3), c(6, 0, 2), c(9, 9, 0))) {
  name <- paste(counts, collapse = "-"); n <- sum(counts)
  for (i in 1:3) {
    wilson <- suppressWarnings(prop.test(counts[i], n, correct = FALSE))$conf.int
    values <- c(wilson[1], wilson[2]); names(values) <- paste0(c("low_", "high_"), i)
    add("preference", name, values)
  }
  sign <- binom.test(counts[1], counts[1] + counts[2])
  add("preference", name, p = sign$p.value, low = sign$conf.int[1], high = sign$conf.int[2])
}

# --- Intraclass correlations, by the mean squares of aov (Shrout & Fleiss 1979; McGraw & Wong) --
wide <- sapply(c("x1", "x2", "x3", "x4"), function(g) of("repeated", g))
fleiss <- rbind(c(9, 2, 5, 8), c(6, 1, 3, 2), c(8, 4, 6, 8), c(7, 1, 2, 6), c(10, 5, 6, 9), c(6, 2, 4, 7))
for (name in c("repeated", "shrout_fleiss")) {
  m <- if (name == "repeated") wide else fleiss
  n <- nrow(m); k <- ncol(m)
  long <- data.frame(y = c(m), who = factor(row(m)), when = factor(col(m)))
  ms <- summary(aov(y ~ who + when, long))[[1]][, "Mean Sq"]
  within <- summary(aov(y ~ who, long))[[1]][2, "Mean Sq"]
  p <- ms[1]; o <- ms[2]; e <- ms[3]
  one <- (p - within) / (p + (k - 1) * within)
  two <- (p - e) / (p + (k - 1) * e + k * (o - e) / n)
  three <- (p - e) / (p + (k - 1) * e)
  add("intraclass", name, "one_1" = one, "two_1" = two, "three_1" = three, "one_k" = (p - within) / p,
      "two_k" = (p - e) / (p + (o - e) / n), "three_k" = (p - e) / p)
  f <- p / e; d <- (n - 1) * (k - 1)
  low <- f / qf(.975, n - 1, d); high <- f * qf(.975, d, n - 1)
  add("intraclass", name, "three_1 low" = (low - 1) / (low + k - 1), "three_1 high" = (high - 1) / (high + k - 1),
      "three_k low" = 1 - 1 / low, "three_k high" = 1 - 1 / high)
  f1 <- p / within; low <- f1 / qf(.975, n - 1, n * (k - 1)); high <- f1 * qf(.975, n * (k - 1), n - 1)
  add("intraclass", name, "one_1 low" = (low - 1) / (low + k - 1), "one_1 high" = (high - 1) / (high + k - 1))
  # Shrout & Fleiss (1979, p. 424): F* with their degrees of freedom nu.
  fj <- o / e
  nu <- d * (k * two * fj + n * (1 + (k - 1) * two) - k * two)^2 /
    ((n - 1) * k^2 * two^2 * fj^2 + (n * (1 + (k - 1) * two) - k * two)^2)
  up <- qf(.975, n - 1, nu); down <- qf(.975, nu, n - 1)
  low <- n * (p - up * e) / (up * (k * o + (k * n - k - n) * e) + n * p)
  high <- n * (down * p - e) / (k * o + (k * n - k - n) * e + n * down * p)
  add("intraclass", name, "two_1 low" = low, "two_1 high" = high,
      "two_k low" = k * low / (1 + (k - 1) * low), "two_k high" = k * high / (1 + (k - 1) * high))
}

# --- Several factors each way: afex, type II and III, sphericity assumed -------------------------
crossed <- read.csv("crossed.csv")
for (set in split(crossed, crossed$dataset)) {
  for (type in 2:3) {
    table <- suppressWarnings(suppressMessages(aov_ez(
      "participant", "value", set, between = c("group", "sex"), within = c("view", "dose"),
      type = type, anova_table = list(correction = "none", es = "ges")
    )))$anova_table
    for (effect in rownames(table)) {
      values <- c(table[effect, "F"], table[effect, "Pr(>F)"])
      names(values) <- paste(type, gsub(":", " × ", effect), c("F", "p"))
      add("crossed", set$dataset[1], values)
    }
  }
}

# --- Aligned ranks, by the definition of Wobbrock et al. (2011), in base R -----------------------
set <- crossed[crossed$dataset == "balanced", ]
names_of <- c("group", "view", "dose")
set[names_of] <- lapply(set[names_of], factor)
ave_by <- function(names) if (length(names)) ave(set$value, do.call(paste, set[names])) else
  rep(mean(set$value), nrow(set))
subsets <- function(x) unlist(lapply(0:length(x), function(k) combn(x, k, simplify = FALSE)), FALSE)
for (effect in subsets(names_of)[-1]) {
  estimate <- 0
  for (part in subsets(effect)) estimate <- estimate + (-1)^(length(effect) - length(part)) * ave_by(part)
  set$ranks <- rank(round(set$value - ave_by(names_of) + estimate, 7))
  model <- summary(aov(ranks ~ group * view * dose + Error(factor(participant) / (view * dose)), set))
  wanted <- paste(effect, collapse = ":")
  for (stratum in model) {
    rows <- trimws(rownames(stratum[[1]]))
    if (wanted %in% rows) {
      values <- unlist(stratum[[1]][which(rows == wanted), c("F value", "Pr(>F)")])
      names(values) <- paste(gsub(":", " × ", wanted), c("F", "p"))
      add("aligned_ranks", "balanced", values)
    }
  }
}

# --- Marginal means of a mixed model: lmerTest, adjusted by Bonferroni ---------------------------
PRECISE <- lmerControl(
  optimizer = "nloptwrap", calc.derivs = TRUE,
  optCtrl = list(xtol_abs = 1e-14, ftol_abs = 1e-16, xtol_rel = 0, ftol_rel = 0, maxeval = 1e5)
)
set <- crossed[crossed$dataset == "unbalanced", ][-c(3, 8, 14, 15, 40, 61), ]
set$dose <- relevel(factor(set$dose), "low")
set[c("view", "group")] <- lapply(set[c("view", "group")], factor)
model <- lmer(value ~ dose + view + group + (1 | participant), set, control = PRECISE)
means <- ls_means(model)
for (i in seq_len(nrow(means))) {
  values <- unlist(means[i, c("Estimate", "Std. Error", "df", "lower", "upper")])
  names(values) <- paste(rownames(means)[i], c("estimate", "standard_error", "df", "low", "high"))
  add("marginal_means", "unbalanced", values)
}
pairs <- ls_means(model, which = "dose", pairwise = TRUE)
count <- nrow(pairs)
for (i in seq_len(count)) {
  e <- pairs[i, "Estimate"]; s <- pairs[i, "Std. Error"]; df <- pairs[i, "df"]
  half <- qt(1 - .025 / count, df) * s
  values <- c(e, s, df, min(1, count * pairs[i, "Pr(>|t|)"]), e - half, e + half)
  names(values) <- paste(rownames(pairs)[i], c("estimate", "standard_error", "df", "p_adjusted", "low", "high"))
  add("marginal_means", "unbalanced", values)
}

write.csv(do.call(rbind, found), "r_output.csv", row.names = FALSE, quote = FALSE, eol = "\n")
writeLines(capture.output(sessionInfo()), "r_session.txt")
