(* Definiteness of symmetric matrices of whole numbers, decided by computation and proved here for
   real vectors: x'Mx > 0 for every x but 0.  Needs Coq's standard library alone, from 8.16 on. *)
Require Import ZArith List Bool Reals Lra Lia.
Import ListNotations.
Open Scope Z_scope.

(* A symmetric matrix by its upper triangle: each row is the diagonal entry, and what follows it. *)
Definition matrix := list (Z * list Z).

(* x'Mx = sum_i (m_ii x_i^2 + 2 x_i sum_{j>i} m_ij x_j), for real x. *)
Fixpoint dot (b : list Z) (x : list R) : R :=
  match b, x with
  | b0 :: b', x0 :: x' => (IZR b0 * x0 + dot b' x')%R
  | _, _ => 0%R
  end.

Fixpoint form (M : matrix) (x : list R) : R :=
  match M, x with
  | (a, b) :: M', x0 :: x' => (IZR a * (x0 * x0) + 2 * x0 * dot b x' + form M' x')%R
  | _, _ => 0%R
  end.

Definition zero (x : list R) : Prop := Forall (fun v => v = 0%R) x.

(* What is to be shown of a matrix of n rows. *)
Definition positive_definite (M : matrix) : Prop :=
  forall x, length x = length M -> ~ zero x -> (0 < form M x)%R.
Definition positive_semidefinite (M : matrix) : Prop :=
  forall x, length x = length M -> (0 <= form M x)%R.

(* The rows have the lengths of an upper triangle. *)
Fixpoint triangle (M : matrix) : bool :=
  match M with
  | [] => true
  | (_, b) :: M' => (length b =? length M')%nat && triangle M'
  end.

(* a M - b b', the Schur complement times the pivot. *)
Fixpoint combined (a c : Z) (d b : list Z) : list Z :=
  match d, b with
  | dj :: d', bj :: b' => (a * dj - c * bj) :: combined a c d' b'
  | _, _ => []
  end.

Fixpoint schur (a : Z) (b : list Z) (M : matrix) : matrix :=
  match b, M with
  | b0 :: b', (c, d) :: M' => (a * c - b0 * b0, combined a b0 d b') :: schur a b' M'
  | _, _ => []
  end.

(* M / p where every entry is a multiple of p, which is looked at and not believed. *)
Fixpoint quotients (p : Z) (b : list Z) : option (list Z) :=
  match b with
  | [] => Some []
  | b0 :: b' =>
      let q := b0 / p in
      if p * q =? b0 then option_map (cons q) (quotients p b') else None
  end.

Fixpoint divided (p : Z) (M : matrix) : option matrix :=
  match M with
  | [] => Some []
  | (a, b) :: M' =>
      let q := a / p in
      if p * q =? a then
        match quotients p b, divided p M' with
        | Some c, Some N => Some ((q, c) :: N)
        | _, _ => None
        end
      else None
  end.

(* Elimination (Bareiss): each pivot must be positive; where [semi], a row of zeros drops out. *)
Fixpoint pivots (semi : bool) (n : nat) (p : Z) (M : matrix) : bool :=
  match n, M with
  | O, [] => true
  | S m, (a, b) :: M' =>
      if semi && (a =? 0) && forallb (Z.eqb 0) b then pivots semi m p M'
      else
        (0 <? a) &&
        match divided p (schur a b M') with
        | Some N => pivots semi m a N
        | None => false
        end
  | _, _ => false
  end.

Definition is_definite (M : matrix) : bool := triangle M && pivots false (length M) 1 M.
Definition is_semidefinite (M : matrix) : bool := triangle M && pivots true (length M) 1 M.

(* ------------------------------------------------------------------ why this is a proof *)

Lemma dot_combined : forall a c d b x, length d = length b -> length x = length b ->
  dot (combined a c d b) x = (IZR a * dot d x - IZR c * dot b x)%R.
Proof.
  intros a c d; induction d as [|d0 d IH]; intros [|b0 b] [|x0 x] Hd Hx; simpl in *;
    try discriminate; try lra.
  rewrite minus_IZR, !mult_IZR, IH by lia. lra.
Qed.

Lemma length_combined : forall a c d b, length d = length b ->
  length (combined a c d b) = length d.
Proof.
  intros a c d; induction d as [|d0 d IH]; intros [|b0 b] H; simpl in *; try discriminate; auto.
Qed.

Lemma length_schur : forall a M b, length b = length M -> length (schur a b M) = length M.
Proof.
  intros a M; induction M as [|[c d] M IH]; intros [|b0 b] H; simpl in *; try discriminate; auto.
Qed.

Lemma triangle_schur : forall a M b, length b = length M -> triangle M = true ->
  triangle (schur a b M) = true.
Proof.
  intros a M; induction M as [|[c d] M IH]; intros [|b0 b] H T; simpl in *; try discriminate; auto.
  apply andb_prop in T; destruct T as [E T]. apply Nat.eqb_eq in E.
  rewrite length_combined by lia. rewrite length_schur by lia.
  rewrite E, Nat.eqb_refl, IH by (auto; lia). reflexivity.
Qed.

Lemma form_schur : forall a M b x, length b = length M -> length x = length M ->
  triangle M = true ->
  form (schur a b M) x = (IZR a * form M x - dot b x * dot b x)%R.
Proof.
  intros a M; induction M as [|[c d] M IH]; intros [|b0 b] [|x0 x] Hb Hx T; simpl in *;
    try discriminate; try lra.
  apply andb_prop in T; destruct T as [E T]. apply Nat.eqb_eq in E.
  rewrite IH by (auto; lia). rewrite dot_combined by lia.
  rewrite minus_IZR, !mult_IZR. ring.
Qed.

Lemma dot_quotients : forall p b c x, quotients p b = Some c -> dot b x = (IZR p * dot c x)%R.
Proof.
  intros p b; induction b as [|b0 b IH]; intros c x H; simpl in H.
  - injection H as <-. simpl. lra.
  - destruct (p * (b0 / p) =? b0) eqn:E; [|discriminate].
    destruct (quotients p b) as [r|]; simpl in H; [|discriminate].
    injection H as <-. apply Z.eqb_eq in E. destruct x as [|x0 x]; simpl; [lra|].
    rewrite (IH r x eq_refl). rewrite <- E at 1. rewrite mult_IZR. ring.
Qed.

Lemma form_divided : forall p M N x, divided p M = Some N -> form M x = (IZR p * form N x)%R.
Proof.
  intros p M; induction M as [|[a b] M IH]; intros N x H; simpl in H.
  - injection H as <-. simpl. lra.
  - destruct (p * (a / p) =? a) eqn:E; [|discriminate].
    destruct (quotients p b) as [c|] eqn:Q; [|discriminate].
    destruct (divided p M) as [K|]; [|discriminate].
    injection H as <-. apply Z.eqb_eq in E. destruct x as [|x0 x]; simpl; [lra|].
    rewrite (IH K x eq_refl), (dot_quotients _ _ _ x Q). rewrite <- E at 1. rewrite mult_IZR. ring.
Qed.

Lemma length_quotients : forall p b c, quotients p b = Some c -> length c = length b.
Proof.
  intros p b; induction b as [|b0 b IH]; intros c H; simpl in H.
  - injection H as <-. reflexivity.
  - destruct (p * (b0 / p) =? b0); [|discriminate].
    destruct (quotients p b) as [r|]; simpl in H; [|discriminate].
    injection H as <-. simpl. rewrite (IH r eq_refl). reflexivity.
Qed.

Lemma length_divided : forall p M N, divided p M = Some N -> length N = length M.
Proof.
  intros p M; induction M as [|[a b] M IH]; intros N H; simpl in H.
  - injection H as <-. reflexivity.
  - destruct (p * (a / p) =? a); [|discriminate].
    destruct (quotients p b); [|discriminate]. destruct (divided p M) as [K|]; [|discriminate].
    injection H as <-. simpl. rewrite (IH K eq_refl). reflexivity.
Qed.

Lemma triangle_divided : forall p M N, divided p M = Some N -> triangle M = true ->
  triangle N = true.
Proof.
  intros p M; induction M as [|[a b] M IH]; intros N H T; simpl in H.
  - injection H as <-. reflexivity.
  - destruct (p * (a / p) =? a); [|discriminate].
    destruct (quotients p b) as [c|] eqn:Q; [|discriminate].
    destruct (divided p M) as [K|] eqn:D; [|discriminate].
    injection H as <-. simpl in *. apply andb_prop in T; destruct T as [E T].
    rewrite (length_quotients _ _ _ Q), (length_divided _ _ _ D), E, (IH K eq_refl T). reflexivity.
Qed.

Lemma dot_zero : forall b x, zero x -> dot b x = 0%R.
Proof.
  intros b; induction b as [|b0 b IH]; intros [|x0 x] H; simpl; auto.
  inversion H; subst. rewrite IH by assumption. lra.
Qed.

Lemma dot_zeros : forall b x, forallb (Z.eqb 0) b = true -> dot b x = 0%R.
Proof.
  intros b; induction b as [|b0 b IH]; intros [|x0 x] H; simpl in *; auto.
  apply andb_prop in H; destruct H as [E H]. destruct b0; try discriminate.
  rewrite IH by assumption. lra.
Qed.

Lemma form_zero : forall M x, zero x -> form M x = 0%R.
Proof.
  intros M; induction M as [|[a b] M IH]; intros [|x0 x] H; simpl; auto.
  inversion H; subst. rewrite IH, dot_zero by assumption. lra.
Qed.

Lemma pivots_sound : forall semi n p M, (0 < p)%Z -> triangle M = true ->
  pivots semi n p M = true ->
  forall x, length x = length M ->
  (0 <= form M x)%R /\ (semi = false -> form M x = 0%R -> zero x).
Proof.
  intros semi n; induction n as [|n IH]; intros p [|[a b] M] Hp T H x Hx; simpl in H;
    try discriminate.
  - destruct x; [|discriminate]. simpl. split; [lra|]. intros _ _. constructor.
  - destruct x as [|x0 x]; [discriminate|]. simpl in T, Hx.
    apply andb_prop in T; destruct T as [E T]. apply Nat.eqb_eq in E.
    destruct (semi && (a =? 0) && forallb (Z.eqb 0) b) eqn:Z0.
    + apply andb_prop in Z0; destruct Z0 as [Z0 B0]. apply andb_prop in Z0; destruct Z0 as [S0 A0].
      apply Z.eqb_eq in A0. subst a semi. simpl. rewrite (dot_zeros _ _ B0).
      destruct (IH p M Hp T H x ltac:(lia)) as [P _]. split; [lra|discriminate].
    + apply andb_prop in H; destruct H as [A H]. apply Z.ltb_lt in A.
      destruct (divided p (schur a b M)) as [N|] eqn:D; [|discriminate].
      assert (TS : triangle (schur a b M) = true) by (apply triangle_schur; auto).
      assert (LS : length (schur a b M) = length M) by (apply length_schur; auto).
      assert (LN : length N = length M) by (rewrite (length_divided _ _ _ D); auto).
      destruct (IH a N A (triangle_divided _ _ _ D TS) H x ltac:(lia)) as [P Q].
      assert (F : form (schur a b M) x = (IZR a * form M x - dot b x * dot b x)%R)
        by (apply form_schur; auto; lia).
      rewrite (form_divided _ _ _ x D) in F. simpl.
      apply IZR_lt in A. apply IZR_lt in Hp.
      set (f := form M x) in *. set (s := dot b x) in *. set (g := form N x) in *.
      set (r := IZR a) in *. set (q := IZR p) in *.
      assert (W : (r * (r * (x0 * x0) + 2 * x0 * s + f) = (r * x0 + s) * (r * x0 + s) + q * g)%R)
        by (assert ((r * f = q * g + s * s)%R) by lra; nra).
      assert (G : (0 <= q * g)%R) by (apply Rmult_le_pos; lra).
      split.
      * apply Rmult_le_reg_l with r; [exact A|]. rewrite Rmult_0_r, W.
        pose proof (Rle_0_sqr (r * x0 + s)) as S0. unfold Rsqr in S0. lra.
      * intros NS V. rewrite V, Rmult_0_r in W.
        pose proof (Rle_0_sqr (r * x0 + s)) as S0. unfold Rsqr in S0.
        assert (G0 : g = 0%R).
        { assert (GG : (q * g = 0)%R) by lra. destruct (Rmult_integral _ _ GG); lra. }
        assert (X : zero x) by (apply Q; assumption).
        constructor; [|exact X].
        assert (s = 0%R) by (apply dot_zero; exact X).
        assert (SQ : ((r * x0 + s) * (r * x0 + s) = 0)%R) by lra.
        destruct (Rmult_integral _ _ SQ) as [Y|Y];
          (assert (YY : (r * x0 = 0)%R) by lra; destruct (Rmult_integral _ _ YY); lra).
Qed.

Theorem is_definite_sound : forall M, is_definite M = true -> positive_definite M.
Proof.
  unfold is_definite, positive_definite. intros M H x L NZ.
  apply andb_prop in H; destruct H as [T H].
  destruct (pivots_sound false _ 1 M ltac:(lia) T H x L) as [P Q].
  destruct (Rle_lt_or_eq_dec _ _ P) as [Y|Y]; [exact Y|]. exfalso. apply NZ. auto.
Qed.

Theorem is_semidefinite_sound : forall M, is_semidefinite M = true -> positive_semidefinite M.
Proof.
  unfold is_semidefinite, positive_semidefinite. intros M H x L.
  apply andb_prop in H; destruct H as [T H].
  exact (proj1 (pivots_sound true _ 1 M ltac:(lia) T H x L)).
Qed.

(* ------------------------------------------------------------------ shorter numbers *)

(* N is M in units s_i s_j, rounded: off the diagonal by less than a unit, on it to the safe side,
   so that x'Mx >= y'Ny with y_i = s_i x_i.  Elimination of N then takes short numbers. *)
Fixpoint beside (s0 : Z) (s b d : list Z) : bool :=
  match s, b, d with
  | [], [], [] => true
  | sj :: s', bj :: b', dj :: d' =>
      (0 <? sj) && (Z.abs (bj - s0 * sj * dj) <=? s0 * sj) && beside s0 s' b' d'
  | _, _, _ => false
  end.

Fixpoint rounded (k : Z) (s : list Z) (M N : matrix) : bool :=
  match s, M, N with
  | [], [], [] => true
  | s0 :: s', (a, b) :: M', (c, d) :: N' =>
      (0 <? s0) && (s0 * s0 * (c + (k + Z.of_nat (length s'))) <=? a) && beside s0 s' b d &&
      rounded (k + 1) s' M' N'
  | _, _, _ => false
  end.

Definition shown (M : matrix) (s : list Z) (N : matrix) : bool := rounded 0 s M N && is_definite N.

Fixpoint stretched (s : list Z) (x : list R) : list R :=
  match s, x with
  | s0 :: s', x0 :: x' => (IZR s0 * x0)%R :: stretched s' x'
  | _, _ => []
  end.

Fixpoint squares (x : list R) : R :=
  match x with x0 :: x' => (x0 * x0 + squares x')%R | [] => 0%R end.

Lemma length_stretched : forall s x, length x = length s -> length (stretched s x) = length s.
Proof.
  intros s; induction s as [|s0 s IH]; intros [|x0 x] H; simpl in *; try discriminate; auto.
Qed.

Lemma one_beside : forall u0 u1 q e x0 x1 : R,
  (0 < u0)%R -> (0 < u1)%R -> (q = u0 * u1)%R -> (- q <= e <= q)%R ->
  (- ((u0 * x0) * (u0 * x0)) - (u1 * x1) * (u1 * x1) <= 2 * x0 * x1 * e)%R.
Proof.
  intros u0 u1 q e x0 x1 H0 H1 -> [L U].
  pose proof (Rle_0_sqr (u0 * x0 - u1 * x1)) as A. pose proof (Rle_0_sqr (u0 * x0 + u1 * x1)) as B.
  unfold Rsqr in A, B. destruct (Rle_or_lt 0 (x0 * x1)) as [S|S].
  - assert ((x0 * x1) * (- (u0 * u1)) <= (x0 * x1) * e)%R by (apply Rmult_le_compat_l; lra). nra.
  - assert ((x0 * x1) * (u0 * u1) <= (x0 * x1) * e)%R.
    { replace ((x0 * x1) * (u0 * u1))%R with (- ((- (x0 * x1)) * (u0 * u1)))%R by ring.
      replace ((x0 * x1) * e)%R with (- ((- (x0 * x1)) * e))%R by ring.
      apply Ropp_le_contravar. apply Rmult_le_compat_l; lra. }
    nra.
Qed.

Lemma beside_sound : forall s0 s b d x0 x, (0 < s0)%Z -> beside s0 s b d = true ->
  length x = length s ->
  (2 * (IZR s0 * x0) * dot d (stretched s x) <=
   2 * x0 * dot b x + IZR (Z.of_nat (length s)) * ((IZR s0 * x0) * (IZR s0 * x0)) +
   squares (stretched s x))%R.
Proof.
  intros s0 s; induction s as [|s1 s IH]; intros [|b1 b] [|d1 d] x0 [|x1 x] P H L;
    try discriminate; simpl beside in H; simpl length in L; try discriminate.
  - simpl. lra.
  - apply andb_prop in H; destruct H as [H B]. apply andb_prop in H; destruct H as [S A].
    apply Z.ltb_lt in S. apply Z.leb_le in A. apply Z.abs_le in A. destruct A as [A1 A2].
    specialize (IH b d x0 x P B ltac:(lia)).
    replace (Z.of_nat (length (s1 :: s))) with (Z.of_nat (length s) + 1)%Z by (simpl length; lia).
    rewrite plus_IZR. simpl dot. simpl stretched. simpl squares.
    apply IZR_le in A1. apply IZR_le in A2. apply IZR_lt in S. apply IZR_lt in P.
    rewrite opp_IZR, minus_IZR, !mult_IZR in A1. rewrite minus_IZR, !mult_IZR in A2.
    pose proof (one_beside (IZR s0) (IZR s1) _ (IZR b1 - IZR s0 * IZR s1 * IZR d1) x0 x1 P S
      eq_refl (conj A1 A2)) as O.
    set (f := dot b x) in *. set (g := dot d (stretched s x)) in *.
    set (h := squares (stretched s x)) in *. set (n := IZR (Z.of_nat (length s))) in *.
    nra.
Qed.

Lemma rounded_length : forall s k M N, rounded k s M N = true ->
  length M = length s /\ length N = length s /\ triangle M = triangle N.
Proof.
  assert (Q : forall s0 s b d, beside s0 s b d = true ->
    length b = length s /\ length d = length s).
  { intros s0 s; induction s as [|s1 s IH]; intros [|b1 b] [|d1 d] H; simpl in H; try discriminate;
      auto. apply andb_prop in H; destruct H as [_ H]. destruct (IH _ _ H). simpl; auto. }
  intros s; induction s as [|s0 s IH]; intros k [|[a b] M] [|[c d] N] H; simpl in H;
    try discriminate; auto.
  apply andb_prop in H; destruct H as [H R]. apply andb_prop in H; destruct H as [_ B].
  destruct (IH _ _ _ R) as [LM [LN T]]. destruct (Q _ _ _ _ B) as [Lb Ld]. simpl.
  rewrite LM, LN, Lb, Ld, T. auto.
Qed.

Lemma rounded_sound : forall s k M N x, rounded k s M N = true -> length x = length s ->
  (form N (stretched s x) + IZR k * squares (stretched s x) <= form M x)%R.
Proof.
  intros s; induction s as [|s0 s IH]; intros k [|[a b] M] [|[c d] N] [|x0 x] H L;
    simpl rounded in H; simpl length in L; try discriminate.
  - simpl. lra.
  - apply andb_prop in H; destruct H as [H R]. apply andb_prop in H; destruct H as [H B].
    apply andb_prop in H; destruct H as [S A]. apply Z.ltb_lt in S. apply Z.leb_le in A.
    specialize (IH (k + 1) M N x R ltac:(lia)).
    pose proof (beside_sound s0 s b d x0 x S B ltac:(lia)) as O.
    apply IZR_le in A. rewrite !mult_IZR, !plus_IZR in A. rewrite plus_IZR in IH.
    simpl form. simpl squares. simpl stretched in *.
    set (f := form M x) in *. set (g := form N (stretched s x)) in *.
    set (p := dot b x) in *. set (q := dot d (stretched s x)) in *.
    set (h := squares (stretched s x)) in *. set (n := IZR (Z.of_nat (length s))) in *.
    set (u := IZR s0) in *.
    pose proof (Rle_0_sqr x0) as X. unfold Rsqr in X.
    assert (D : ((u * u * (IZR c + (IZR k + n))) * (x0 * x0) <= IZR a * (x0 * x0))%R)
      by (apply Rmult_le_compat_r; lra).
    nra.
Qed.

Lemma stretched_zero : forall s x k M N, rounded k s M N = true -> length x = length s ->
  zero (stretched s x) -> zero x.
Proof.
  intros s; induction s as [|s0 s IH]; intros [|x0 x] k [|[a b] M] [|[c d] N] H L Z0;
    simpl rounded in H; simpl length in L; try discriminate; [constructor|].
  apply andb_prop in H; destruct H as [H R]. apply andb_prop in H; destruct H as [H _].
  apply andb_prop in H; destruct H as [S _]. apply Z.ltb_lt in S. apply IZR_lt in S.
  simpl stretched in Z0. inversion Z0; subst. constructor.
  - match goal with E : (IZR s0 * x0 = 0)%R |- _ => destruct (Rmult_integral _ _ E); lra end.
  - eapply IH; eauto; lia.
Qed.

Theorem shown_sound : forall M s N, shown M s N = true -> positive_definite M.
Proof.
  unfold shown, positive_definite. intros M s N H x L NZ.
  apply andb_prop in H; destruct H as [R D]. destruct (rounded_length _ _ _ _ R) as [LM [LN _]].
  pose proof (rounded_sound s 0 M N x R ltac:(lia)) as G.
  assert (F : (0 < form N (stretched s x))%R).
  { apply (is_definite_sound N D).
    - rewrite length_stretched; lia.
    - intros Y. apply NZ. eapply stretched_zero; eauto; lia. }
  lra.
Qed.

(* ------------------------------------------------------------------ matrices as written *)
From Coq Require Import Init.Byte.

Inductive text := Text (written : list byte).
Definition text_of (b : list byte) : text := Text b.
Definition bytes_of (t : text) : list byte := let (b) := t in b.
Declare Scope text_scope.
Delimit Scope text_scope with text.
String Notation text text_of bytes_of : text_scope.

Definition digit (b : byte) : option Z :=
  match b with
  | x30 => Some 0 | x31 => Some 1 | x32 => Some 2 | x33 => Some 3 | x34 => Some 4
  | x35 => Some 5 | x36 => Some 6 | x37 => Some 7 | x38 => Some 8 | x39 => Some 9
  | _ => None
  end.

(* Upper triangles: numbers end with ",", rows with "/", matrices with ";"; spaces and line ends
   are skipped. *)
Fixpoint read (b : list byte) (value : Z) (minus : bool) (row : list Z) (rows : matrix)
    (found : list matrix) : option (list matrix) :=
  match b with
  | [] => match row, rows with [], [] => Some (rev found) | _, _ => None end
  | x2c (* , *) :: b' => read b' 0 false ((if minus then - value else value) :: row) rows found
  | x2d (* - *) :: b' => read b' value true row rows found
  | x2f (* / *) :: b' =>
      match rev row with
      | a :: rest => read b' 0 false [] ((a, rest) :: rows) found
      | [] => None
      end
  | x3b (* ; *) :: b' => read b' 0 false [] [] (rev rows :: found)
  | x0a :: b' | x20 :: b' => read b' value minus row rows found
  | c :: b' =>
      match digit c with
      | Some d => read b' (10 * value + d) minus row rows found
      | None => None
      end
  end.

Definition matrices (t : text) : option (list matrix) := read (bytes_of t) 0 false [] [] [].

(* A text of M, s, N; M, s, N; ... holds so many matrices M, and each is positive definite. *)
Fixpoint firsts (l : list matrix) : list matrix :=
  match l with M :: _ :: _ :: l' => M :: firsts l' | _ => [] end.

Fixpoint all_shown (l : list matrix) : bool :=
  match l with
  | [] => true
  | M :: [(s0, s)] :: N :: l' => shown M (s0 :: s) N && all_shown l'
  | _ => false
  end.

Definition hold (n : nat) (t : text) : Prop :=
  exists l, matrices t = Some l /\ length (firsts l) = n /\ Forall positive_definite (firsts l).
Definition holdb (n : nat) (t : text) : bool :=
  match matrices t with Some l => (length (firsts l) =? n)%nat && all_shown l | None => false end.

Lemma all_shown_sound : forall k l, (length l <= k)%nat -> all_shown l = true ->
  Forall positive_definite (firsts l).
Proof.
  intros k; induction k as [|k IH]; intros [|M [|[|[s0 s] [|q r]] [|N l]]] L H; simpl in *;
    try discriminate; try constructor; try lia.
  - apply andb_prop in H; destruct H as [S _]. eapply shown_sound; eauto.
  - apply andb_prop in H; destruct H as [_ H]. apply IH; [lia|exact H].
Qed.

Theorem hold_sound : forall n t, holdb n t = true -> hold n t.
Proof.
  intros n t H. unfold holdb in H. destruct (matrices t) as [l|] eqn:E; [|discriminate].
  apply andb_prop in H; destruct H as [N H]. apply Nat.eqb_eq in N.
  exists l. repeat split; auto. apply (all_shown_sound (length l)); auto.
Qed.

(* The same for positive semidefinite matrices, which stand by themselves. *)
Definition hold_semi (n : nat) (t : text) : Prop :=
  exists l, matrices t = Some l /\ length l = n /\ Forall positive_semidefinite l.
Definition holdb_semi (n : nat) (t : text) : bool :=
  match matrices t with
  | Some l => (length l =? n)%nat && forallb is_semidefinite l
  | None => false
  end.

Theorem hold_semi_sound : forall n t, holdb_semi n t = true -> hold_semi n t.
Proof.
  intros n t H. unfold holdb_semi in H. destruct (matrices t) as [l|] eqn:E; [|discriminate].
  apply andb_prop in H; destruct H as [N H]. apply Nat.eqb_eq in N. rewrite forallb_forall in H.
  exists l. repeat split; auto. apply Forall_forall. intros M I. apply is_semidefinite_sound. auto.
Qed.
